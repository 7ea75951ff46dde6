# A mechanism: postproc/draw makes the files of its frames and scene.gp, in the working folder.
# gnuplot -c draw.gp png|svg|gif|webm FOLDER_OF_STYLE OUTPUT_FILE
format = ARG1; postproc = ARG2; output_file = ARG3
load 'scene.gp'
animated = format eq 'gif' || format eq 'webm'
has(layer) = strstrt(layers.' ', ' '.layer.' ') > 0
# The box with a margin, and not too slender; equal axes
margin = 0.05*(right - left > top - bottom ? right - left : top - bottom)
left = left - margin; right = right + margin; bottom = bottom - margin; top = top + margin
least = 0.25*(right - left > top - bottom ? right - left : top - bottom)
if (top - bottom < least) { middle = 0.5*(top + bottom); bottom = middle - 0.5*least; top = middle + 0.5*least }
if (right - left < least) { middle = 0.5*(right + left); left = middle - 0.5*least; right = middle + 0.5*least }
room_left = 2.5; room_right = 0.4; room_bottom = 1.6; room_top = 1.4
plot_width = 16 - room_left - room_right
plot_height = plot_width*(top - bottom)/(right - left)
if (plot_height > 14) { plot_height = 14; plot_width = plot_height*(right - left)/(top - bottom) }
width = 16; height = plot_height + room_bottom + room_top
from = room_left + 0.5*(16 - room_left - room_right - plot_width)
load postproc.'/style.gp'
set xrange [left:right]
set yrange [bottom:top]
eval panel(from, from + plot_width, room_bottom, room_bottom + plot_height)
set label 'x ['.unit.']' noenhanced at screen (from + 0.5*plot_width)/width,0.35/height center
set label 'y ['.unit.']' noenhanced at screen (from - 2.05)/width,(room_bottom + 0.5*plot_height)/height center rotate
set label heading noenhanced at screen 0.5,1 - 0.45/height center
# The same tics along both axes, at most eight
rough = (right - left > top - bottom ? right - left : top - bottom)/8
power = 10**floor(log10(rough))
step = rough > 5*power ? 10*power : rough > 2*power ? 5*power : rough > power ? 2*power : power
set format '%g'
# In SVG gnuplot writes the numbers a line too low
set xtics step offset 0,(format eq 'svg' ? 0.5 : 0)
set ytics step
magnified_by = factor + 0 == 1 || !has('beams') ? '' : ', deflections × '.factor
time_label = sprintf('noenhanced at screen %f,%f right', (from + plot_width)/width, 1 - 1.05/height)

# Colour of a body, whitened by a part of the way
colours = '0x0072B2 0xD55E00 0x009E73 0xCC79A7 0xE69F00 0x56B4E9 0x8C6D31'
whiter(c, part) = int(c + part*(255 - c))
mixed(rgb, part) = 65536*whiter(rgb/65536, part) + 256*whiter(rgb/256%256, part) + whiter(rgb%256, part)
colour(body, part) = body < 1 ? mixed(0x404040, part) : mixed(int(word(colours, 1 + int(body - 1)%7)), part)

# Lines are thinner where symbols, which are smaller than bodies, are less than 1.2 mm
thin = symbol*plot_width/(right - left)/0.12
thin = thin > 1 ? 1 : thin < 0.4 ? 0.4 : thin
wide(points) = sprintf('linewidth %g', points*thin)

# Commands of the layers of frame `frame`, whitened by `part`
file(frame) = sprintf("'%d.txt'", frame)
layer(frame, name, how) = has(name) ? sprintf("%s index '%s' %s, ", file(frame), name, how) : ''
stroke(part, line) = sprintf('using 1:2:(colour($3, %g)) with lines %s dashtype solid linecolor rgb variable', part, line)
fills(frame, name, part) = has(name) ? sum_fills(frame, name, part, 0) : ''
sum_fills(frame, name, part, i) = i > 7 ? '' : layer(frame, name, sprintf( \
   "using 1:(%s ? $2 : NaN) with filledcurves closed fillstyle solid 1 noborder fillcolor rgb %d", \
   i == 0 ? '$3 < 1' : sprintf('$3 > 0 && int($3 + 6)%%7 == %d', i - 1), \
   colour(i, part + 0.75*(1 - part)))).sum_fills(frame, name, part, i + 1)
disc(rgb, size) = sprintf('using 1:2:(%g*$4) with circles fillstyle solid 1 noborder fillcolor rgb %d', size, rgb)
drawn(frame, part) = fills(frame, 'wheels', part).layer(frame, 'wheels', stroke(part, wide(1.6))) \
   .fills(frame, 'areas', part) \
   .(animated || ground_moves || frame == frames - 1 ? layer(frame, 'ground', stroke(part, wide(0.9))) : '') \
   .layer(frame, 'guides', stroke(part, wide(1.2))) \
   .layer(frame, 'areas', stroke(part, wide(2))) \
   .layer(frame, 'bars', stroke(part, wide(3.6))) \
   .layer(frame, 'undeformed', sprintf('with lines %s dashtype (6,5) linecolor rgb %d', wide(0.8), mixed(0x808080, part))) \
   .layer(frame, 'springs', stroke(part, wide(1.2))) \
   .layer(frame, 'beams', stroke(part, wide(2.6))) \
   .fills(frame, 'blocks', part).layer(frame, 'blocks', stroke(part, wide(1.6))) \
   .layer(frame, 'masses', sprintf('using 1:2:4:(colour($3, %g)) with circles fillstyle solid 1 noborder linecolor rgb variable', part)) \
   .layer(frame, 'joints', disc(mixed(0x202020, part), 1.0)).layer(frame, 'joints', disc(0xFFFFFF, 0.66))
paths = has('paths') ? "'paths.txt' index 'paths' using 1:2:(colour($3, 0.2)) with lines linewidth 1.2 dashtype (2,3) linecolor rgb variable, " : ''

if (animated) {
   do for [i = 0:frames - 1] {
      if (format eq 'webm') { set output sprintf('%d.png', i) }
      eval 'set label 100 time[i + 1].magnified_by '.time_label
      commands = drawn(i, 0.0).paths
      eval 'plot '.commands[:strlen(commands) - 2]
   }
} else {
   commands = ''
   do for [i = 0:frames - 1] {
      commands = commands.drawn(i, frames > 1 ? 0.8*(frames - 1 - i)/(frames - 1) : 0.0)
   }
   span = frames > 1 ? sprintf('%d instants, %s to %s', frames, time[1], substr(time[frames], 5, 99)) : time[1]
   eval 'set label 100 span.magnified_by '.time_label
   commands = commands.paths
   eval 'plot '.commands[:strlen(commands) - 2]
}
