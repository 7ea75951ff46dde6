# Lines `abscissa value`, sorted by both -> abscissa, median, lower and upper quartile for each abscissa
function write_group(  quarter) {
  if (n == 0) return
  quarter = int((n + 3) / 4)
  print abscissa, (n % 2 ? value[(n + 1) / 2] : (value[n / 2] + value[n / 2 + 1]) / 2), value[quarter], value[n + 1 - quarter]
  n = 0
}
BEGIN { print "# abscissa  median  lower quartile  upper quartile [us]" }
$1 != abscissa { write_group(); abscissa = $1 }
{ value[++n] = $2 }
END { write_group() }
