# An SVG of gnuplot made small: points of strokes and fills that lie within `near` of the line that the others make are left out
# (Douglas and Peucker), and so are empty groups, symbols that nothing uses and titles that browsers show as hints.
# awk [-v near=0.1] -f thin.awk BIG.svg > SMALL.svg                  near: in the SVG's unit, of which 96 are an inch
BEGIN { if (near == "") near = 0.1 }
# Marks the points between first and last that must stay, by the one that is farthest from their line
function mark(first, last, limit,    i, dx, dy, length2, d, far, which) {
  if (last < first + 2) return
  dx = x[last] - x[first]; dy = y[last] - y[first]; length2 = dx*dx + dy*dy
  far = limit*limit; which = 0
  for (i = first + 1; i < last; i++) {
    d = length2 > 0 ? ((x[i] - x[first])*dy - (y[i] - y[first])*dx)^2/length2 : (x[i] - x[first])^2 + (y[i] - y[first])^2
    if (d > far) { far = d; which = i }
  }
  if (which == 0) return
  stays[which] = 1
  mark(first, which, limit)
  mark(which, last, limit)
}
function short(number) { number = sprintf("%.2f", number); sub(/\.?0+$/, "", number); return number == "-0" ? "0" : number }
# 'M1,2 L3,4 ...' or '1,2 3,4 ...', of which only the points that stay are left
function thinned(points, limit,    n, i, word, words, out, count, letter, pair, start, text) {
  n = split(points, word, /[ \t\n]+/)
  count = 0; out = ""
  for (i = 1; i <= n + 1; i++) {
    letter = i <= n ? substr(word[i], 1, 1) : "M"
    if (i > n || letter == "M") {
      out = out stroke(count, limit)
      count = 0
      if (i > n) break
    }
    if (word[i] == "") continue
    text = word[i]
    if (letter == "Z" || letter == "z") { out = out stroke(count, limit) "z"; count = 0; continue }
    path = letter == "M" || letter == "L"
    if (path) text = substr(text, 2)
    if (split(text, pair, ",") != 2) return points
    count++
    x[count] = pair[1] + 0; y[count] = pair[2] + 0; stays[count] = 0
  }
  return out
}
function stroke(count, limit,    i, out, last) {
  if (count == 0) return ""
  stays[1] = stays[count] = 1
  mark(1, count, limit)
  out = ""
  for (i = 1; i <= count; i++) {
    if (!stays[i]) continue
    out = out (out == "" ? (path ? "M" : "") : path ? "L" : " ") short(x[i]) "," short(y[i])
  }
  return out
}
# The attribute that begins with `opening` in a text, thinned
function treated(text, opening, limit,    at, rest, end, head) {
  head = ""
  while (at = index(text, opening)) {
    rest = substr(text, at + length(opening))
    end = index(rest, "'")
    head = head substr(text, 1, at + length(opening) - 1) thinned(substr(rest, 1, end - 1), limit) "'"
    text = substr(rest, end + 1)
  }
  return head text
}
# Strokes of one colour that follow each other as one path
function joined(text,    at, rest, head, end) {
  while (match(text, /<path stroke='[^']*'  d='[^']*'\/>[ \t]*<path stroke='[^']*'  d='/)) {
    head = substr(text, RSTART, RLENGTH)
    end = index(substr(head, 2), "<path") + 1
    rest = substr(head, end)
    if (substr(head, 1, index(head, "  d='")) != substr(rest, 1, index(rest, "  d='"))) {
      done = done substr(text, 1, RSTART + end - 2)
      text = substr(text, RSTART + end - 1)
      continue
    }
    at = RSTART
    head = substr(head, 1, end - 1)
    sub(/'\/>[ \t]*$/, "", head)
    text = substr(text, 1, at - 1) head substr(text, at + RLENGTH)
  }
  text = done text
  done = ""
  return text
}
# Lines up to the end of an attribute belong together
{
  line = $0
  while (line ~ /(d='M|points = ')[^']*$/ && (getline more) > 0) line = line " " more
  if (line !~ /id='gp/) {
    if (index(line, " d='M")) line = treated(line, " d='", near)
    if (index(line, " points = '")) { path = 0; line = treated(line, " points = '", near) }
  }
  gsub(/ shape-rendering='crispEdges'/, "", line)
  if (line !~ /<title>Gnuplot/) gsub(/<title>[^<]*<\/title>/, "", line)
  line = joined(line)
  sub(/^[ \t]+/, "", line); gsub(/[ \t]+\/>/, "/>", line); sub(/[ \t]+$/, "", line)
  if (line != "") lines[++number] = line
}
END {
  used = 0
  for (i = 1; i <= number; i++) if (lines[i] ~ /<use / && lines[i] !~ /id='gp/ || lines[i] ~ /filter=/) used = 1
  kept = 0
  for (i = 1; i <= number; i++) {
    if (!used && lines[i] == "<defs>") { while (lines[i] != "</defs>") i++; continue }
    # A group that holds nothing goes with its beginning, one in the other
    if (lines[i] == "</g>" && keep[kept] ~ /^<g [^>]*>$/) { kept--; continue }
    keep[++kept] = lines[i]
  }
  for (i = 1; i <= kept; i++) print keep[i]
}
