# What `limber export --motion` prints -> paths.txt and 0.txt, 1.txt, ..., a file for each sample, in the working folder; on standard
# output what draw.gp must know: the layers that there are, the box of all points, heading, unit and times. Texts come from the
# results: gnuplot evaluates nothing between single quotes, numbers are written as numbers
function quoted(text) { gsub(/[\001-\037\177]/, " ", text); gsub(/'/, "''", text); return "'" text "'" }
# The ground is drawn once if it is the same in all frames
function end_frame() { if (frames > 1 && ground != first_ground) ground_moves = 1; if (frames == 1) first_ground = ground; ground = "" }
BEGIN { frames = 0; ground = ""; ground_moves = 0; file = "paths.txt"; layer = "" }
# A heading longer than a line ends at a mark, or else at a blank
/^# heading / {
  heading = substr($0, 11)
  if (length(heading) > 76) {
    heading = substr(heading, 1, 75)
    if (match(heading, /.*[,;:(]/) && RLENGTH > 30) heading = substr(heading, 1, RLENGTH - 1)
    else sub(/ [^ ]*$/, " …", heading)
    sub(/ +$/, "", heading)
  }
  next
}
/^# unit / { unit = substr($0, 8); next }
/^# symbol / { symbol = $3 + 0; next }
/^# sample / {
  if (frames > 0) { close(file); end_frame() }
  file = frames ".txt"
  time[++frames] = substr($0, index($0, ",") + 2)
  next
}
/^# undeformed$/ && ENVIRON["undeformed"] == "no" { layer = ""; next }
/^# [a-z]+$/ { layer = $2; if (!(layer in known)) { known[layer] = 1; layers = layers " " layer } }
NF >= 3 && layer != "" && !/^#/ {
  r = NF > 3 ? $4 : 0
  if (!boxed) { left = right = $1; bottom = top = $2; boxed = 1 }
  if ($1 - r < left) left = $1 - r
  if ($1 + r > right) right = $1 + r
  if ($2 - r < bottom) bottom = $2 - r
  if ($2 + r > top) top = $2 + r
}
layer == "ground" && !/^#/ { ground = ground $0 "\n" }
{ print > file }
END {
  end_frame()
  printf "frames = %d\nlayers = '%s'\nheading = %s\nunit = %s\nsymbol = %.9e\nfactor = %s\narray time[%d]\n", \
    frames, layers, quoted(heading), quoted(unit), symbol, quoted(ENVIRON["factor"]), frames
  printf "ground_moves = %d\n", ground_moves
  printf "left = %.9e; right = %.9e; bottom = %.9e; top = %.9e\n", left, right, bottom, top
  for (i = 1; i <= frames; i++) printf "time[%d] = %s\n", i, quoted(time[i])
}
