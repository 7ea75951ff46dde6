# time, crank angle, x and y of 11 points of the rod from crank pin to slider -> for each drawn angle of the second turn one
# data set, divided by two blank lines: x, y of the points, and the same with their distance from the chord magnified.
# The first line of a data set is the crank's bearing.
BEGIN { turn = 2 * 3.14159265358979324; drawn = 8; count = 0 }
/^#/ { next }
count < drawn && $2 > turn * (1 + count / drawn) - 1e-6 {
  if ($2 > turn * (1 + count / drawn) + 1e-6) {
    print "mechanism.awk: no sample at the crank angle " turn * (1 + count / drawn) > "/dev/stderr"
    exit 1
  }
  printf "%s# crank angle %g degrees in the second turn\n", (count > 0 ? "\n\n" : ""), 360 * count / drawn
  print 0, 0, 0, 0
  dx = $(NF - 1) - $3; dy = $NF - $4; length_of_chord = sqrt(dx^2 + dy^2)
  nx = -dy / length_of_chord; ny = dx / length_of_chord
  for (i = 3; i < NF; i += 2) {
    distance = ($i - $3) * nx + ($(i + 1) - $4) * ny
    print $i, $(i + 1), $i + (factor - 1) * distance * nx, $(i + 1) + (factor - 1) * distance * ny
  }
  count++
}
