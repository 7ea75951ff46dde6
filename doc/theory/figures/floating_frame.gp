# Figure 1.1: the floating frame, and a point of a body that deforms
format = ARG1; columns = ARG2; output_file = ARG3
width = 14; height = 8.4
load 'style.gp'
eval panel(0.3, 13.7, 0.3, 8.1)
unset border; unset tics
set xrange [-0.3:13.1]
set yrange [-0.3:7.5]
# Angle of the frame, its origin, length of the beam, place of the point
a = 0.36; rx = 3.9; ry = 1.0; l = 9.0; sp = 6.6
fx(p, q) = rx + p*cos(a) - q*sin(a)
fy(p, q) = ry + p*sin(a) + q*cos(a)
bent(s) = 2.7*(s/l)**2*(1.6 - 0.6*s/l)
thick = 0.28
set parametric
set trange [0:l]
set samples 200
arrow(n, x0, y0, x1, y1, type) = sprintf("set arrow %d from %f,%f to %f,%f linetype %d filled size 0.28,18;", n, x0, y0, x1, y1, type)
eval arrow(1, 0.5, 0.5, 2.3, 0.5, 3).arrow(2, 0.5, 0.5, 0.5, 2.3, 3)
eval arrow(3, fx(0,0), fy(0,0), fx(2.1,0), fy(2.1,0), 2).arrow(4, fx(0,0), fy(0,0), fx(0,2.1), fy(0,2.1), 2)
eval arrow(5, 0.5, 0.5, rx, ry, 3).arrow(6, 0.5, 0.5, fx(sp, bent(sp)), fy(sp, bent(sp)), 3)
eval arrow(7, fx(sp,0), fy(sp,0), fx(sp,bent(sp)), fy(sp,bent(sp)), 2)
eval arrow(8, fx(0,0), fy(0,0), fx(sp,bent(sp)), fy(sp,bent(sp)), 4)
set label 1 'fixed axes' at 0.2,0.05 left
set label 2 '{/:Italic u}' at fx(2.15,-0.35),fy(2.15,-0.35)
set label 3 '{/:Italic v}={/:Italic Ju}' at fx(-0.1,2.4),fy(-0.1,2.4) right
set label 4 '{/:Italic r}' at 2.5,0.45
set label 5 '{/:Italic x}' at 4.3,3.5
set label 6 '{/:Italic φη}' at fx(sp+0.2,0.6),fy(sp+0.2,0.6)
set label 7 '{/:Italic P}' at fx(sp-0.1,bent(sp)+0.45),fy(sp-0.1,bent(sp)+0.45)
set label 8 '{/:Italic p}' at fx(3.0,1.35),fy(3.0,1.35)
set label 9 'undeformed' at fx(5.4,-0.6),fy(5.4,-0.6) rotate by 20
plot fx(t,thick/2),fy(t,thick/2) with lines linecolor rgb '#999999' linewidth 1.2 dashtype (6,4), \
   fx(t,-thick/2),fy(t,-thick/2) with lines linecolor rgb '#999999' linewidth 1.2 dashtype (6,4), \
   fx(t,bent(t)+thick/2),fy(t,bent(t)+thick/2) with lines linetype 1, \
   fx(t,bent(t)-thick/2),fy(t,bent(t)-thick/2) with lines linetype 1, \
   '+' using (fx(sp,bent(sp))):(fy(sp,bent(sp))) every ::0::0 with points linetype 1 pointsize 0.9, \
   '+' using (fx(sp,0)):(fy(sp,0)) every ::0::0 with points linetype 9 pointtype 6 pointsize 0.8
