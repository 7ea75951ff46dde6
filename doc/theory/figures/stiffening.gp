# Figure 2.2: the first frequency of a rotating cantilever by the models of its tension; what `draw` computes
format = ARG1; columns = ARG2; output_file = ARG3
width = 14; height = 8
load 'style.gp'
eval panel(1.8, 13.6, 1.7, 6.9).x_label(7.7, 'speed of rotation Ω [√(EI/ρAL^4)]').y_label(4.3, 'first frequency [√(EI/ρAL^4)]')
eval key_line(1.8, 1, 'exact').key_line(4.4, 2, 'LINEAR').key_line(7.5, 4, 'K_G, 8 elements')
set label 25 'K_G, 1 element' at 5.0,4.85 right
set label 26 'LINEAR: unstable from 3.516 on' at 3.75,0.3
set xrange [0:12]
set yrange [0:6]
set ytics 1
plot columns.'/exact.txt' using 1:2 smooth csplines with lines linetype 1, \
   columns.'/linear.txt' using 1:($2 > 0 ? $2 : ($1 < 3.7 ? 0 : NaN)) with lines linetype 2, \
   columns.'/one.txt' using 1:2 with lines linetype 3, \
   columns.'/kg.txt' using 1:2 with lines linetype 4
