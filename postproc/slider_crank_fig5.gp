# Figure 5 of Han and Lee (1993): 6 modes from 10 elements, and the exact beam as a reference
format = ARG1; columns = ARG2; output_file = ARG3
width = 16; height = 10
load 'style.gp'
eval panel(2.3, 15.4, 1.7, 8.9).x_label(8.85, crank_angle).y_label(5.3, deflection)
eval key_line(2.5, 2, 'linear').key_line(5.9, 1, 'k_G, 2 elements').key_line(11.3, 3, 'exact beam')
eval two_turns
eval deflections
plot columns.'/fig5_linear.txt' using 2:3 with lines linetype 2, \
   columns.'/fig5_kg.txt' using 2:3 with lines linetype 1, \
   columns.'/exact.txt' using 2:3 with lines linetype 3
