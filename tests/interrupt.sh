#!/bin/sh
# Decks with several analyses, and searches for a TARGET, that are ended by signals or killed at moments all over their time: the former
# go on to the bits and the report of a run that was left alone; the latter leave with status 4, say what they have found, and leave
# nothing that passes for a result.
#   tests/interrupt.sh LIMBER INPUT WORK ["MOMENTS"]
# MOMENTS are parts of the time of a whole run: "0.1 0.3 0.5 0.7 0.9" unless told
limber=$1
input=$2
work=$3
moments=${4:-0.1 0.3 0.5 0.7 0.9}
rm -rf "$work"
mkdir -p "$work" || exit 1
cd "$work" || exit 1

fail() {
  echo "$deck, $signal at $moment s: $*"
  cat messages
  exit 1
}
# What a run reports, but for seconds, where it went on and the name of its file
lines() { grep -v "s CPU\|: continued at\|: begun anew" "$1" | sed 's/in [a-z]*\.h5/in file/'; }
# Seconds of a whole run, left in whole.h5 and report
measure() {
  start=$(date +%s.%N)
  "$limber" run $deck.inp --force -o whole.h5 > report 2>&1 || { cat report; exit 1; }
  time=$(echo "$start $(date +%s.%N)" | awk '{ print $2 - $1 }')
}
# start OPTIONS...: a run that is sent the signal after a part of that time
start() {
  moment=$(awk "BEGIN { print $part*$time }")
  "$limber" run $deck.inp --quiet -o run.h5 "$@" > messages 2>&1 &
  process=$!
  sleep $moment
  kill -$signal $process 2> /dev/null
  wait $process 2> /dev/null
  status=$?
  # Before the run begins there is nothing to keep: as a kill
  if [ $status -eq 4 ] && grep -q "^limber: ended at once by a signal" messages; then status=143; fi
}

sed 's/^\*DYNAMICS.*/*KINEMATICS, END=0.01, OUTPUTS=500\
*DYNAMICS, END=0.04, TOLERANCE=1e-7, OUTPUTS=500, INTEGRATOR=ADAMS\
*DYNAMICS, END=0.08, TOLERANCE=1e-6, OUTPUTS=500, INTEGRATOR=RADAU\
*KINEMATICS, END=0.09, OUTPUTS=500\
*SCALAR\
 most = maximum(slider_x), rms(crank_angle)/; s/^\*OUTPUT$/*OUTPUT, ENVELOPE=rod/' "$input/slider_crank_exact.inp" > several.inp
sed '/^\*OUTPUT/,$d; s/^\*DYNAMICS.*/*MODES, NUMBER=3\
*DYNAMICS, END=3, OUTPUTS=100, TOLERANCE=1e-9\
*STATICS, NAME=more, INCREMENTS=500/; s/INCREMENTS=4$/INCREMENTS=500/' "$input/cantilever_statics.inp" > statics.inp
cat >> statics.inp <<'TEXT'
*OUTPUT, ENVELOPE=beam
 y_tip = u2(beam.end), wall_force = force_y(wall), kinetic = kinetic_energy(system)
*SCALAR
 most = -minimum(y_tip), rms(wall_force)
TEXT
interrupted=0
for deck in several statics; do
  measure
  signal=TERM
  for part in $moments; do
    rm -f run.*
    start --checkpoint 0.01
    if [ $status -eq 4 ]; then
      interrupted=$((interrupted + 1))
      grep -q "^$deck.inp: \*.*: interrupted by SIG$signal at t = .* with --restart" messages || fail "does not say what it did"
      [ -e run.checkpoint.h5 ] || fail "no checkpoint"
      "$limber" export run.h5 > /dev/null || fail "is not readable"
    elif [ $status -lt 128 ] && [ $status -ne 0 ]; then
      fail "status $status"
    fi
    # Once more, killed, on the way to the end
    interruption=$signal
    signal=KILL
    start --checkpoint 0.01 --restart
    signal=$interruption
    "$limber" run $deck.inp --restart -o run.h5 > messages 2>&1 || fail "does not go on"
    "$limber" diff run.h5 whole.h5 --rtol 0 --range 0 > difference || { cat difference; fail "other bits"; }
    if ! grep -q "nothing left to do" messages; then
      lines report > wanted
      lines messages | cmp - wanted || fail "another report"
    fi
    if command -v h5diff > /dev/null; then
      for object in /step /scalars /run/steps /bodies /modes; do
        h5diff -q whole.h5 run.h5 $object > /dev/null 2>&1
        [ $? -ne 1 ] || fail "another $object"
      done
    fi
    [ "$(ls run.*)" = run.h5 ] || fail "leaves $(ls run.*)"
    case $signal in TERM) signal=USR1 ;; USR1) signal=INT ;; *) signal=TERM ;; esac
  done
done
[ $interrupted -gt 0 ] || { echo "no run was interrupted"; exit 1; }

# A search: whether the deck is found wanting or not, status 4 leaves nothing, or the run that it had come to, marked incomplete
sed 's/^\*DYNAMICS.*/*DYNAMICS, END=turns*2*pi\/speed, OUTPUTS=838\
*ACCURACY, TARGET=2e-3/' "$input/slider_crank_exact.inp" > search.inp
deck=search
measure
interrupted=0
signal=TERM
for part in 0.2 0.5 0.7 0.8 0.9; do
  rm -f run.*
  start
  if [ $status -eq 4 ]; then
    interrupted=$((interrupted + 1))
    grep -q "search.inp: the search for TARGET=0.002 was interrupted by SIG$signal in the run '.*; it has no checkpoints and begins anew" \
      messages || fail "does not say what it did"
    grep -q "TOLERANCE=" messages || fail "does not say what it found"
    if [ -e run.h5 ]; then
      if grep -q "The target is kept.*still being tried" messages; then
        [ "$("$limber" export run.h5 | wc -l)" -eq 840 ] || fail "not a whole run"
      else
        grep -q "None was found so far that keeps the target; this one" messages || fail "leaves results without a reason"
      fi
      grep -q "run.h5, marked incomplete" messages || fail "does not say what is left"
      "$limber" run search.inp --quiet --restart -o run.h5 > messages 2>&1
      [ $? -eq 2 ] && grep -q "the search for a TARGET cannot go on, it can be run anew with --force" messages || fail "is not refused"
    else
      grep -q "No results were written" messages || fail "does not say what is left"
      [ -z "$(ls run.* 2> /dev/null)" ] || fail "leaves $(ls run.*)"
    fi
  elif [ $status -eq 0 ]; then
    "$limber" diff run.h5 whole.h5 --rtol 0 --range 0 > messages || fail "other bits"
  elif [ $status -lt 128 ]; then
    fail "status $status"
  fi
  case $signal in TERM) signal=USR1 ;; USR1) signal=INT ;; *) signal=TERM ;; esac
done
[ $interrupted -gt 0 ] || { echo "no search was interrupted"; exit 1; }
echo "all as it should be"
