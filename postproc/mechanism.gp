# The mechanism to scale at eight crank angles of the second turn, the rod as it is and with its deflection magnified
format = ARG1; columns = ARG2; output_file = ARG3; magnification = ARG4
width = 16; height = 19
load 'style.gp'
set linetype 6 linecolor rgb 'black' linewidth 3 dashtype solid pointtype 7 pointsize 0.5
set linetype 7 linecolor rgb 'black' pointtype 5 pointsize 0.9
drawn = columns.'/mechanism_drawn.txt'
set multiplot
eval key_line(2.0, 6, 'crank').key_line(4.9, 1, 'rod').key_line(7.5, 2, 'rod, deflection × '.magnification).key_point(12.6, 7, 'slider')
eval x_label(5.4, 'x [m]').x_label(12.4, 'x [m]')
do for [row=0:3] { eval y_label(16.1 - 4.2*row, 'y [m]') }
# Equal axes: 6.475 cm for 0.7 m, 3.7 cm for 0.4 m
set xrange [-0.20:0.50]
set yrange [-0.20:0.20]
set xtics 0.2
set mxtics 2
set ytics 0.1
do for [i=0:7] {
   column = i/4
   row = i%4
   eval panel(2.1 + 7.0*column, 8.575 + 7.0*column, 14.25 - 4.2*row, 17.95 - 4.2*row)
   set label 100 sprintf('θ = %d°', 360 + 45*i) at graph 0.97,0.92 right
   set format x (row == 3 ? '%.1f' : '')
   set format y (column == 0 ? '%.1f' : '')
   plot 0 with lines linetype 9, \
      drawn index i every ::0::1 using 1:2 with linespoints linetype 6, \
      drawn index i every ::1 using 3:4 with lines linetype 2, \
      drawn index i every ::1 using 1:2 with lines linetype 1, \
      drawn index i every ::11::11 using 1:2 with points linetype 7
   eval drawn_once
}
unset multiplot
