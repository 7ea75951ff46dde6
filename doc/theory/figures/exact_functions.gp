# Figure 2.3: candidates of the bending moment of an exact cantilever with a force inside, eqs. (X3) and (Y3) of the theory: each
# has neither moment nor shear force at the free end
format = ARG1; columns = ARG2; output_file = ARG3
width = 16; height = 7
load 'style.gp'
eval panel(1.9, 15.6, 1.7, 6.0).x_label(8.7, 'place along the beam, s/L [–]').y_label(3.8, 'moment [–]')
eval key_line(1.9, 2, 'force at 0.4').key_line(6.0, 1, 'first mode').key_line(9.8, 4, '(1 − s)^2').key_line(12.9, 3, '(1 − s)^3')
b = 1.875104068711961
factor = (cosh(b) + cos(b))/(sinh(b) + sin(b))
# The second derivative of the mode
bow(x) = 0.5*(cosh(b*x) + cos(b*x) - factor*(sinh(b*x) + sin(b*x)))
# max(0, s - 0.4) less the line that it ends on
kink(x) = x < 0.4 ? 0.4 - x : 0
set samples 400
set xrange [0:1]
set yrange [0:1.05]
set ytics 0.2 format '%.1f'
set xtics 0.2 format '%.1f'
plot kink(x)/0.4 with lines linetype 2, bow(x) with lines linetype 1, (1 - x)**2 with lines linetype 4, \
   (1 - x)**3 with lines linetype 3
