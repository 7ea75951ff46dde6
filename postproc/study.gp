# Work and precision of a study: error against CPU time of the time loop. postproc/study makes the columns:
# integrator, CPU seconds, error, error at the end, on the front, one run in a line.
# gnuplot -c study.gp png|svg COLUMNS OUTPUT_FILE 'ADAMS RADAU' COLUMNS_OF_THE_FRONT
format = ARG1; columns = ARG2; output_file = ARG3; names = ARG4; front = ARG5
width = 16; height = 9
load 'style.gp'
set linetype 1 linewidth 1 pointtype 7 pointsize 0.6
set linetype 2 linewidth 1 pointtype 4 pointsize 0.8 dashtype solid
set linetype 4 linewidth 1 pointtype 9 pointsize 0.8 dashtype solid
type_of(i) = i < 3 ? i : i + 1
at = 0.2
do for [i = 1:words(names)] {
   eval key_point(at, type_of(i), word(names, i))
   at = at + 1.2 + 0.23*strlen(word(names, i))
}
eval key_line(at + 0.6, 3, 'Pareto front')
eval x_label(8.6, 'CPU time of the time loop [s]')
eval y_label(4.6, 'error of the worst channel, relative')
eval panel(2.0, 15.6, 1.6, 8.0)
set logscale xy
set format x '10^{%T}'
set format y '10^{%T}'
plot front using 2:3 with lines linetype 3, \
   for [i = 1:words(names)] columns using (column(1) == i ? column(2) : NaN):3 with points linetype type_of(i)
