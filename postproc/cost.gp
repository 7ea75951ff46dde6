# CPU time of the time loop for one right-hand side against elements and modes
format = ARG1; columns = ARG2; output_file = ARG3
width = 16; height = 8
load 'style.gp'
set linetype 1 linewidth 1 pointtype 7 pointsize 0.6
set linetype 2 linewidth 1 pointtype 4 pointsize 0.8 dashtype solid
all_series = 'elements modes_linear modes_kg geometric'
file(series) = sprintf('%s/cost_%s.txt', columns, series)
highest = 0
do for [series in all_series] {
   stats file(series) using 4 nooutput
   highest = STATS_max > highest ? STATS_max : highest
}
set multiplot
eval key_point(1.2, 2, 'linear').key_point(4.2, 1, 'k_G').key_text(6.7, 'median and quartiles of the runs')
eval x_label(3.55, 'finite elements').x_label(8.60, 'modes').x_label(13.65, 'k_G elements')
eval y_label(4.3, 'CPU time per evaluation [µs]')
set yrange [0:1.1*highest]
set ytics 2
eval panel(1.4, 5.7, 1.6, 7.0)
set logscale x 2
set xrange [7:230]
set xtics (10, 20, 40, 80, 160)
plot file('elements') with yerrorbars linetype 1
eval drawn_once
set format y ''
eval panel(6.45, 10.75, 1.6, 7.0)
unset logscale x
set xrange [0.3:9.7]
set xtics 1,1,9
plot file('modes_linear') using ($1 - 0.13):2:3:4 with yerrorbars linetype 2, \
   file('modes_kg') using ($1 + 0.13):2:3:4 with yerrorbars linetype 1
eval panel(11.5, 15.8, 1.6, 7.0)
set logscale x 2
set xrange [0.75:27]
set xtics (1, 2, 5, 10, 20)
plot file('geometric') with yerrorbars linetype 1
unset multiplot
