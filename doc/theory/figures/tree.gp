# Figure 4.1: a driven four-bar linkage with a pendulum, and its tree
format = ARG1; columns = ARG2; output_file = ARG3
width = 17; height = 7
load 'style.gp'
unset border; unset tics
set xrange [0:17]
set yrange [0:7]
eval panel(0.0001, 17, 0.0001, 7)
link(n, x0, y0, x1, y1) = sprintf("set arrow %d from %f,%f to %f,%f nohead linetype 1 linewidth 4;", n, x0, y0, x1, y1)
pin(x, y) = sprintf("set object circle at %f,%f size 0.13 fillcolor rgb 'white' fillstyle solid border linecolor rgb 'black' linewidth 1.2 front;", x, y)
# The mechanism
eval link(1, 2.0,1.4, 2.6,3.2).link(2, 2.6,3.2, 5.6,4.9).link(3, 5.6,4.9, 6.2,1.4).link(4, 4.1,4.05, 4.2,2.4)
eval pin(2.0,1.4).pin(2.6,3.2).pin(5.6,4.9).pin(6.2,1.4).pin(4.1,4.05)
set object circle at 4.2,2.3 size 0.28 fillcolor rgb '#0072B2' fillstyle solid noborder front
set arrow 5 from 1.2,1.2 to 7,1.2 nohead linetype 3
set label 1 'crank,' at 2.1,2.7 right
set label 6 'driven' at 2.1,2.2 right
set label 2 'coupler' at 3.9,4.7 right
set label 3 'rocker' at 6.2,3.3
set label 4 'pendulum' at 4.1,1.65 center
set label 5 'ground' at 4.1,0.7 center
# The tree
box(x, y, text, more) = sprintf("set object rectangle center %f,%f size 3.1,1.05 fillcolor rgb '#f4f4f4' fillstyle solid border linecolor rgb 'black'; \
   set label '%s' at %f,%f center front; set label '%s' at %f,%f center front;", x, y, text, x, y + 0.24, more, x, y - 0.24)
eval box(12, 0.75, 'ground', 'known').box(10.1, 2.6, 'crank', 'known').box(10.1, 4.45, 'coupler', '1 unknown')
eval box(10.1, 6.3, 'pendulum', '1 unknown').box(14.4, 2.6, 'rocker', '1 unknown')
set arrow 11 from 11.5,1.3 to 10.6,2.05 linetype 2 dashtype solid
set arrow 12 from 10.1,3.15 to 10.1,3.9 linetype 2 dashtype solid
set arrow 13 from 10.1,5.0 to 10.1,5.75 linetype 2 dashtype solid
set arrow 14 from 12.6,1.3 to 13.8,2.05 linetype 2 dashtype solid
set arrow 15 from 11.7,4.45 to 14.4,3.15 nohead linetype 3 linewidth 2 dashtype (6,5)
set label 20 'closes the loop:' at 13.5,4.5 left
set label 21 '2 multipliers' at 13.5,4.0 left
plot NaN notitle
