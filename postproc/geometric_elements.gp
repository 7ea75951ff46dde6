# Deflection with 1, 2, 5 and 10 k_G elements, and the differences from 10; 6 modes from 10 elements
format = ARG1; columns = ARG2; output_file = ARG3
width = 16; height = 14
load 'style.gp'
file(n) = sprintf('%s/kg_%d.txt', columns, n)
difference(n) = sprintf('%s/kg_%d_10.txt', columns, n)
set multiplot
eval key_line(2.4, 2, '1 k_G element').key_line(7.2, 1, '2').key_line(9.8, 4, '5').key_line(12.4, 3, '10')
eval x_label(8.85, crank_angle).y_label(10.4, 'v/L [–]').y_label(4.4, '1000 (v − v_{10})/L [–]')
eval panel(2.3, 15.4, 7.8, 13.0)
eval two_turns
eval deflections
set xtics ('' 0, '' pi/2 1, '' pi, '' 3*pi/2 1, '' 2*pi, '' 5*pi/2 1, '' 3*pi, '' 7*pi/2 1, '' 4*pi)
plot file(1) using 2:3 with lines linetype 2, \
   file(2) using 2:3 with lines linetype 1, \
   file(5) using 2:3 with lines linetype 4, \
   file(10) using 2:3 with lines linetype 3
eval drawn_once
eval panel(2.3, 15.4, 1.7, 7.1)
eval two_turns
set yrange [-1.2:1.2]
set ytics 0.5 format '%.1f'
unset mytics
plot difference(1) using 2:(1e3*($3 - $6)) with lines linetype 2, \
   difference(2) using 2:(1e3*($3 - $6)) with lines linetype 1, \
   difference(5) using 2:(1e3*($3 - $6)) with lines linetype 4
unset multiplot
