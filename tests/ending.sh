#!/bin/sh
# Commands that are ended by a signal in the midst of their work: status 4 and a word on standard error, whatever they are at. What was
# computed is kept and marked incomplete, a sweep and a run go on later, and nothing is left under the name of a whole result.
#   tests/ending.sh LIMBER INPUT WORK
limber=$1
input=$2
work=$3
rm -rf "$work"
mkdir -p "$work" || exit 1
cd "$work" || exit 1

fail() {
  echo "$what, $signal after $moment s: $*"
  tail -n 20 messages
  exit 1
}
# interrupt COMMAND...: sends the signal until it comes before the end: earlier if that was too late; with `gently`, later if it was so
# early that the command could only end at once
gently=yes
interrupt() {
  moment=1
  early=0
  late=
  for try in 1 2 3 4 5 6 7 8 9 10 11 12; do
    rm -rf left.*
    "$limber" "$@" > output 2> messages &
    process=$!
    sleep $moment
    kill -$signal $process 2> /dev/null
    wait $process
    status=$?
    if [ $status -eq 0 ]; then
      late=$moment
    else
      [ $status -eq 4 ] || fail "status $status"
      [ -s messages ] || fail "no word"
      [ $gently = yes ] && grep -q "^limber: ended at once by a signal" messages || return
      early=$moment
    fi
    moment=$(awk "BEGIN { print ($early + ${late:-3*$moment})/2 }")
  done
  fail "it was never interrupted"
}
says() { grep -q "$1" messages || fail "does not say '$1'"; }

# A chain so long that everything takes its time
cat > chain.inc <<'TEXT'
*GRAVITY, Y=-9.81
*RIGID BODY, NAME=b0, MASS=1, INERTIA=0.1, CENTRE X=0.5
 end, 1, 0
*JOINT, NAME=j0, TYPE=REVOLUTE
 b0.origin, ground.origin
*REPEAT, COUNT=n, INDEX=i, FROM=1
*RIGID BODY, NAME=b<i>, MASS=1, INERTIA=0.1, CENTRE X=0.5, X=i
 end, 1, 0
*JOINT, NAME=j<i>, TYPE=REVOLUTE
 b<i>.origin, b<i - 1>.end
*TORQUE, NAME=t<i>, BODY=b<i>, REACTION=b<i - 1>
 -0.001*(angle(b<i>) - angle(b<i - 1>)) - 0.01*(spin(b<i>) - spin(b<i - 1>))
*END REPEAT
TEXT
chain() { printf '*PARAMETER\n n = %s\n*INCLUDE, FILE=chain.inc\n' $1; }
{ chain 300; echo '*STATICS, NAME=hang, INCREMENTS=1'; printf '*OUTPUT\n y = y(b9.end)\n'; } > statics.inp
{ chain 300; echo '*MODES, NAME=first, NUMBER=9, DAMPED=YES'; printf '*OUTPUT\n y = y(b9.end)\n'; } > modes.inp
{ chain 60000; echo '*DYNAMICS, END=1'; printf '*OUTPUT\n y = y(b9.end)\n'; } > check.inp
sed 's/^\*DYNAMICS.*/*KINEMATICS, END=100, OUTPUTS=200000/' "$input/slider_crank_prescribed.inp" > kinematics.inp
sed 's/^\*INVERSE DYNAMICS.*/*INVERSE DYNAMICS, END=100, OUTPUTS=200000/' "$input/slider_crank_inverse.inp" > inverse.inp
sed 's/END=2\*2\*pi/END=10*2*pi/; s/10:105:20/10:105:10/; s/6e-3, 8e-3, 10e-3, 12e-3/6e-3, 12e-3/' "$input/sweep_speed.inp" > sweep.inp
{ sed '/^\*SWEEP/,$d; s/END=10/END=200/' sweep.inp; printf '*STUDY, REPEATS=2\n tolerances, 1e-4, 1e-5, 1e-6\n integrators, RADAU, ADAMS\n'; } > study.inp
sed '/^\*SCALAR/,$d; s/BENDING MODES=3, AXIAL MODES=0,//; s/GEOMETRIC=LINEAR, //; s/END=10/END=5000/' sweep.inp > advise.inp

signal=TERM
for what in statics kinematics inverse; do
  interrupt run $what.inp --quiet -o left.h5
  says "^$what.inp: \*.*: interrupted by SIG$signal at t = .* --restart"
  says "left.h5, marked incomplete"
  [ -e left.checkpoint.h5 ] || fail "no checkpoint"
  "$limber" export left.h5 > /dev/null || fail "is not readable"
  [ "$(ls left.*)" = "left.checkpoint.h5
left.h5" ] || fail "leaves $(ls left.*)"
  case $signal in TERM) signal=USR1 ;; USR1) signal=INT ;; *) signal=TERM ;; esac
done

# While LAPACK computes nobody looks: the run ends at once, as all was written before
what=modes
signal=TERM
gently=no
interrupt run modes.inp --quiet -o left.h5
grep -q "interrupted by SIGTERM at t = 0.* --restart" messages || says "^limber: ended at once by a signal"
"$limber" run modes.inp --quiet --restart -o left.h5 > messages 2>&1 || fail "does not go on"
[ "$(ls left.*)" = left.h5 ] || fail "leaves $(ls left.*)"

what=check
interrupt check check.inp
says "^limber: ended at once by a signal"
what=run
interrupt run check.inp -o left.h5
[ -z "$(ls left.* 2> /dev/null)" ] || fail "leaves $(ls left.*)"

what=advise
interrupt advise advise.inp --write left.inp
[ -z "$(ls left.* 2> /dev/null)" ] || fail "leaves $(ls left.*)"

gently=yes
# A study: its table has what has run
what=study
interrupt study study.inp --quiet -o left.h5
says "study.inp: interrupted by SIGTERM"
says "left.h5 is marked incomplete"
[ "$(ls left.*)" = left.h5 ] || fail "leaves $(ls left.*)"

# A sweep goes on to what it would have been
what=sweep
"$limber" sweep sweep.inp --quiet --jobs 2 -o whole.h5 > messages 2>&1 || fail "does not run"
for signal in TERM INT; do
  interrupt sweep sweep.inp --quiet --jobs 2 -o left.h5
  says "sweep.inp: interrupted by SIG$signal; .* of 20 rows are done"
  says "The summary, marked incomplete, is in left.h5"
  grep -q ",missing," left.csv || fail "no row is missing"
  grep -q ",crashed," left.csv && fail "a row counts as crashed"
done
"$limber" sweep sweep.inp --quiet --jobs 2 -o left.h5 > messages 2>&1 || fail "does not go on"
for table in left whole; do cut -d, -f1-5,7-9 $table.csv > $table.columns; done
cmp left.columns whole.columns || fail "another table"

# Too little memory [kB], wherever it is missed: status 3 and a word. Sanitizers themselves need more than any limit
what=memory
signal="less and less memory"
{ chain 2000; echo '*DYNAMICS, END=1e-3'; printf '*OUTPUT\n y = y(b9.end)\n'; } > memory.inp
if (ulimit -v 400000 && "$limber" --version) > messages 2>&1; then
  few=0
  for moment in 95000 90000 85000 80000 75000 70000 65000 60000 55000; do
    (ulimit -v $moment && exec "$limber" run memory.inp --quiet --force -o left.h5) > messages 2>&1
    status=$?
    case $status in
      0) ;;
      3) few=1; [ -s messages ] || fail "no word" ;;
      # Not even its libraries find room
      127) break ;;
      # One limit in a hundred: libgfortran asks for 32 bytes before it says anything, and calls itself for ever if there are none
      139) [ -s messages ] && fail "crashes" ;;
      *) fail "status $status" ;;
    esac
  done
  [ $few -eq 1 ] || fail "it was always enough"
fi
echo "all as it should be"
