#!/usr/bin/env bash
# The decks of doc/tutorial.md, cut out of its fenced blocks ```inp NAME, and its commands, lines of ```sh blocks that begin with limber:
# they run without a word of warning but where the text shows one, and numbers that the text gives are those of closed forms.
#   tutorial.sh LIMBER TUTORIAL WORK
set -uo pipefail
export LC_ALL=C
limber=$1 tutorial=$2 work=$3
rm -rf "$work"; mkdir -p "$work/bin"; cd "$work" || exit 1
ln -s "$limber" bin/limber
export PATH=$work/bin:$PATH
failed=0
complain() { printf 'FAILED: %s\n' "$*"; failed=1; }

awk '/^```/ { if (open) { open = 0; close(file); next }
              open = 1; file = "/dev/null"
              if ($1 == "```inp" && NF == 2) { file = $2; print file > "decks.txt" }
              if ($1 == "```sh") file = "commands.txt"
              next }
     open { print >> file }' "$tutorial"
[[ -s decks.txt && -s commands.txt ]] || { complain "no decks or commands in $tutorial"; exit 1; }
while read -r deck; do
  grep -q "^limber [a-z]* $deck" commands.txt || complain "no command of the text takes $deck"
done < decks.txt

# Each command in the order of the text; diff has something to tell
while read -r line; do
  [[ $line == limber\ * ]] || { complain "not a command of limber: $line"; continue; }
  read -ra words <<< "$line"
  "${words[@]}" > out.txt 2> err.txt < /dev/null
  status=$?
  expected=0
  [[ ${words[1]} == diff ]] && expected=1
  [[ $status -eq $expected ]] || { complain "status $status of: $line"; cat out.txt err.txt; }
  [[ ${words[1]} == run ]] && cat out.txt err.txt > "${words[2]%.inp}.txt"
  if grep -q '^warning' out.txt err.txt && [[ $line != *swing.inp* ]]; then complain "a warning of: $line"; cat out.txt err.txt; fi
done < commands.txt

# near WHAT VALUE CLOSED_FORM RELATIVE_TOLERANCE [NUMBER AS THE TEXT HAS IT]
near() {
  awk -v a="$2" -v b="($3)" -v r="$4" 'BEGIN { gsub(/[()]/, "", b); exit !(a != "" && (a - b)^2 <= (r*b)^2) }' ||
    complain "$1 is '$2', not $3 within $4"
  [[ $# -lt 5 ]] || grep -qF -- "$5" "$tutorial" || complain "$1: the text does not say $5"
}
of() { awk "BEGIN { pi = atan2(0, -1); g = 9.81; printf \"%.9e\", $1 }"; }
# scalar FILE NAME; at FILE CHANNEL SAMPLE, from 0
scalar() { awk -v name="$2" '$1 == name && $2 == "=" { print $3 }' "$1"; }
at() { limber export "$1" "$2" | awk -v row="$3" 'NR == row + 2 { print $2 }'; }

# The pendulum falls: sqrt(3 g/l), 5/2 of its weight
near 'spin at the lowest point' "$(scalar pendulum.txt fastest)" "$(of 'sqrt(3*g)')" 5e-4 5.4249
near 'pull at the lowest point' "$(scalar pendulum.txt pull)" "$(of '2.5*2*g')" 5e-4 49.05
# Bending moment of a falling bar, m g l/27; about twice that, let go suddenly
near 'bending moment' "$(scalar quiet.txt largest)" "$(of '7850*0.05*0.005*g/27')" 1e-3 0.71304
near 'bending moment of the sudden start' "$(scalar swing.txt largest)" "$(of '2*7850*0.05*0.005*g/27')" 0.1
# A quarter of a turn: an eighth of two turns in 400 intervals
near 'slider at a quarter of a turn' "$(at rod.h5 slider_x 50)" "$(of 'sqrt(0.4^2 - 0.1^2)')" 1e-4 0.38730
near 'slider after a whole turn' "$(at rod.h5 slider_x 200)" 0.5 1e-4
grep -q 'TARGET=0.001: kept' target.txt || { complain 'the target is not kept'; cat target.txt; }
# The largest deflection of a run to a thousandth, and of one with the default tolerance
near 'largest deflection' "$(awk '$1 == "deflection_rod_middle" { print $2 }' target.txt)" \
  "$(limber export rod.h5 deflection_rod_middle | awk 'NR > 1 { d = $2*$2; if (d > m) m = d } END { printf "%.9e", sqrt(m) }')" 1e-3 2.156
near 'ratio of deflections' "$(awk -v a="$(at speeds.sweep.h5 largest 1)" -v b="$(at speeds.sweep.h5 largest 0)" 'BEGIN { print a/b }')" 4.16 2e-3 4.16
# Cantilever: F l**3/(3 E I), (1.8751041)**2 sqrt(E I/(rho A l**4)); Euler's column
limber run shelf.inp --force > shelf.txt
stiffness='2.1e11*0.05*0.005^3/12'
near 'deflection of the tip' "$(at shelf.h5 y_shelf_end 4)" "$(of "-1/(3*$stiffness)")" 1e-4 3.0476
near 'first frequency' "$(awk '$1 == 1 && NF == 4 { print $2 }' shelf.txt)" "$(of "1.8751041^2*sqrt($stiffness/(7850*0.05*0.005))")" 1e-4 26.249
near 'critical load' "$(awk '/equilibrium turns unstable/ { sub(/.*load factor /, ""); print $1 + 0 }' column.txt)" 0.5 1e-4 269.87
near "Euler's load" "$(at column.h5 force_y_foot 10)" "$(of "pi^2*$stiffness/4")" 1e-6
[[ $failed -eq 0 ]] && echo 'the tutorial says what limber does'
exit $failed
