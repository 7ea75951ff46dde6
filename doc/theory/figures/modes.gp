# Figure 2.1: the first three bending modes of uniform beams, in closed form
format = ARG1; columns = ARG2; output_file = ARG3
width = 16; height = 7
load 'style.gp'
array cf[3] = [1.875104068711961, 4.694091132974174, 7.854757438237613]
array cp[3] = [3.926602312047919, 7.068582745628732, 10.210176122813031]
factor(b) = (cosh(b) + cos(b))/(sinh(b) + sin(b))
free(b, x) = 0.5*(cosh(b*x) - cos(b*x) - factor(b)*(sinh(b*x) - sin(b*x)))
pinned(b, x) = cosh(b*x) - cos(b*x) - (sinh(b*x) - sin(b*x))/tanh(b)
set samples 300
set xrange [0:1]
set yrange [-1.15:1.15]
set ytics 0.5 format '%.1f'
set xtics 0.5 format '%.1f'
set xzeroaxis linetype 9
set multiplot
eval key_line(3.6, 1, 'first').key_line(6.8, 2, 'second').key_line(10.4, 4, 'third')
eval x_label(9.05, 'place along the beam, s/L [–]').y_label(3.7, 'deflection [–]')
set label 10 'clamped and free' at screen 4.35/width,5.9/height center
set label 11 'on pins' at screen 9.05/width,5.9/height center
set label 12 'clamped and pinned' at screen 13.75/width,5.9/height center
eval panel(2.4, 6.3, 1.8, 5.6)
plot free(cf[1],x) with lines linetype 1, free(cf[2],x) with lines linetype 2, free(cf[3],x) with lines linetype 4
eval drawn_once
set format y ''
eval panel(7.1, 11.0, 1.8, 5.6)
plot sin(pi*x) with lines linetype 1, sin(2*pi*x) with lines linetype 2, sin(3*pi*x) with lines linetype 4
eval panel(11.8, 15.7, 1.8, 5.6)
plot pinned(cp[1],x)/1.5106 with lines linetype 1, pinned(cp[2],x)/1.5127 with lines linetype 2, \
   pinned(cp[3],x)/1.5127 with lines linetype 4
unset multiplot
