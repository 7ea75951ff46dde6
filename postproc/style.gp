# What all figures share. The caller sets `format` (png, svg, gif or webm), `output_file`, `width` and `height` in cm;
# fonts and lines have the sizes of a page on which the figure is as wide as that. An animation gets 25 frames a second,
# which are written as PNG for WebM.
dots_per_inch = format eq 'png' ? 200.0 : format eq 'svg' ? 96.0 : 144.0
# Even numbers, as films need them
size_x = 2*int(width/2.54*dots_per_inch/2 + 0.5)
size_y = 2*int(height/2.54*dots_per_inch/2 + 0.5)
magnified = dots_per_inch/96
set encoding utf8
if (format eq 'gif') {
   set terminal gif animate delay 4 loop 0 size size_x,size_y font 'sans-serif,11' fontscale magnified linewidth magnified enhanced background 'white'
}
if (format eq 'png' || format eq 'webm') {
   set terminal pngcairo size size_x,size_y font 'sans-serif,11' fontscale magnified linewidth magnified pointscale magnified background 'white'
}
if (format eq 'svg') {
   set terminal svg size size_x,size_y font 'sans-serif,14.7' enhanced background 'white'
}
if (format ne 'webm') { set output output_file }
set minussign
set border 3 linewidth 0.8
set tics nomirror out scale 0.7,0.4
unset key

# Colours of Okabe and Ito, which the colour-blind tell apart; dashes and widths for those who print in grey
set linetype 1 linecolor rgb '#0072B2' linewidth 2.2 dashtype solid pointtype 7
set linetype 2 linecolor rgb '#D55E00' linewidth 2.0 dashtype (9,4) pointtype 4
set linetype 3 linecolor rgb '#000000' linewidth 0.8 dashtype solid pointtype 6
set linetype 4 linecolor rgb '#009E73' linewidth 2.0 dashtype (9,4,2,4) pointtype 9
set linetype 9 linecolor rgb '#999999' linewidth 0.6 dashtype solid

# A text as gnuplot evaluates it to itself: between single quotes
quoted(text) = "'".doubled(text, 1)."'"
doubled(text, i) = i > strlen(text) ? '' : (text[i:i] eq "'" ? "''" : text[i:i]).doubled(text, i + 1)

# Places in cm from the left and from the bottom of the figure, for `eval`
panel(left, right, bottom, top) = sprintf("set lmargin at screen %f; set rmargin at screen %f; \
   set bmargin at screen %f; set tmargin at screen %f;", left/width, right/width, bottom/height, top/height)
x_label(at, text) = sprintf("set label %s at screen %f,%f center;", quoted(text), at/width, 0.4/height)
y_label(at, text) = sprintf("set label %s at screen %f,%f center rotate;", quoted(text), 0.45/width, at/height)
# Gnuplot's own key gives all entries the width of the longest and knows it badly in SVG
key_text(at, text) = sprintf("set label %s at screen %f,%f;", quoted(text), (at + 1.3)/width, 1 - 0.5/height)
key_line(at, type, text) = sprintf("set arrow from screen %f,%f rto screen %f,0 nohead linetype %d;", \
   at/width, 1 - 0.5/height, 1.1/width, type).key_text(at, text)
key_point(at, type, text) = sprintf("set label '' at screen %f,%f point linetype %d;", (at + 0.9)/width, 1 - 0.5/height, type) \
   .key_text(at, text)
# After the first of several panels: labels and key are drawn only once
drawn_once = 'unset arrow; unset label'

# Two turns of the crank
two_turns = "set xrange [0:4*pi]; set xzeroaxis linetype 9; \
   set xtics ('0' 0, '' pi/2 1, 'π' pi, '' 3*pi/2 1, '2π' 2*pi, '' 5*pi/2 1, '3π' 3*pi, '' 7*pi/2 1, '4π' 4*pi)"
crank_angle = 'crank angle θ [rad]'
deflections = "set yrange [-0.02:0.02]; set ytics 0.01 format '%.2f'; set mytics 2"
deflection = 'mid-point deflection over length, v/L [–]'
