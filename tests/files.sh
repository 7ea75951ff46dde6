#!/bin/sh
# No file is lost, and none is waited for: what is not limber's stays as it is, whatever --force says; the deck, what it includes and
# devices are never replaced; pipes are refused; a damaged checkpoint or damaged results are refused, and nothing is touched.
#   files.sh LIMBER WORK
limber=$1
work=$2
rm -rf "$work"
mkdir -p "$work" || exit 1
cd "$work" || exit 1
failed=0
complain() { echo "FAILED: $*"; cat "$work/messages"; failed=1; }
# expect STATUS TEXT COMMAND...: within ten seconds
expect() {
  wanted=$1
  text=$2
  shift 2
  timeout 20 "$@" > "$work/messages" 2>&1
  status=$?
  { [ $status -eq "$wanted" ] && grep -q -e "$text" "$work/messages"; } || complain "$*: status $status for $wanted, '$text'"
}
# keeps FILE: it is still what `note FILE` has seen
note() { cp -p "$1" "$work/noted"; ls -i "$1" > "$work/number"; }
keeps() { { cmp -s "$1" "$work/noted" && [ "$(ls -i "$1")" = "$(cat "$work/number")" ]; } || complain "$1 is not what it was"; }

deck='*RIGID BODY, NAME=rod, MASS=1, INERTIA=0.1, CENTRE X=0.5
 tip, 1, 0
*JOINT, NAME=pin, TYPE=REVOLUTE
 rod.origin, ground.origin
*INCLUDE, FILE=gravity.inc
*TABLE, NAME=push, FILE=push.csv
*FORCE, NAME=pushes, POINT=rod.tip
 push(t), 0
*DYNAMICS, END=1, OUTPUTS=4
*OUTPUT
 x(rod.tip)'
echo "$deck" > n.inp
echo '*GRAVITY' > gravity.inc
printf '0, 0\n2, 1\n' > push.csv
printf '%s\n*PARAMETER\n mass = 1\n*SWEEP, FILE=values.csv\n' "$deck" > s.inp
printf 'mass\n1\n2\n' > values.csv
expect 0 samples "$limber" run n.inp -o own.h5

# Files of somebody else that have the names of what limber makes for a while
echo 'a diary' > text
for name in n.checkpoint.h5 n.checkpoint.h5.new n.h5.running n.h5.new; do
  for file in text own.h5; do
    # A results file may be what a kill has left of limber's own, but no checkpoint
    [ $file = own.h5 ] && [ $name != n.checkpoint.h5 ] && continue
    cp $file $name
    note $name
    expect 2 "$name is in the way" "$limber" run n.inp
    expect 2 "$name is in the way" "$limber" run n.inp --force
    keeps $name
    [ ! -e n.h5 ] || complain "n.h5 was made"
    rm $name
  done
done
mkdir n.h5.running
expect 2 "Is a directory" "$limber" run n.inp --force
rmdir n.h5.running

# The deck and its files, by any name; devices; folders
ln n.inp hard.h5
ln -s n.inp soft.h5
for name in n.inp ./n.inp "$work/n.inp" hard.h5 soft.h5 gravity.inc push.csv; do
  note $name
  expect 2 "is a file of the deck, which is never replaced" "$limber" run n.inp -o "$name" --force
  keeps $name
done
note n.inp
expect 2 "is a file of the deck" "$limber" advise n.inp --write n.inp --force
expect 2 "is a file of the deck" "$limber" study n.inp -o n.inp --force
keeps n.inp
cp n.inp x.h5.running
note x.h5.running
expect 2 "is a file of the deck" "$limber" run x.h5.running -o x.h5 --force
keeps x.h5.running
for device in /dev/null /dev/full; do
  expect 2 "it is a pipe or a device" "$limber" run n.inp -o $device --force
  [ -c $device ] || complain "$device is gone"
done
note values.csv
expect 2 "values.csv is a file of the deck" "$limber" sweep s.inp -o values.h5 --force
keeps values.csv
note text
cp text other.csv
note other.csv
expect 2 "is no table of a sweep" "$limber" sweep s.inp -o other.h5
keeps other.csv
cp text own.csv.new
note own.csv.new
expect 2 "is no table of a sweep" "$limber" sweep s.inp -o own.h5 --force
keeps own.csv.new
rm own.csv.new
expect 0 "2 rows: 2 ok" "$limber" sweep s.inp -o swept.h5
expect 0 "2 rows were done already" "$limber" sweep s.inp -o swept.h5
echo 'what I did today' > swept.rows/mine.journal
note swept.rows/mine.journal
expect 0 "s.inp: 2 rows: 2 ok" "$limber" sweep s.inp -o swept.h5 --force
grep -q "done already" messages && complain "--force goes on with what was done"
keeps swept.rows/mine.journal
cp text kept.inp.new
note kept.inp.new
expect 0 "The deck with these choices is kept.inp" "$limber" advise n.inp --write kept.inp
keeps kept.inp.new

# Pipes
mkfifo pipe pipe.h5 pipe.checkpoint.h5
for command in run check advise study sweep; do
  expect 2 "it is a pipe or a device" "$limber" $command pipe
done
sed 's/gravity.inc/pipe/' n.inp > includes.inp
sed 's/push.csv/pipe/' n.inp > tables.inp
sed 's/values.csv/pipe/' s.inp > sweeps.inp
expect 2 "it is a pipe or a device" "$limber" run includes.inp
expect 2 "it is a pipe or a device" "$limber" run tables.inp
expect 2 "it is a pipe or a device" "$limber" sweep sweeps.inp
expect 2 "pipe" "$limber" export pipe.h5
expect 2 "pipe" "$limber" diff own.h5 pipe.h5
expect 2 "pipe" "$limber" run n.inp -o pipe.h5
expect 2 "pipe" "$limber" run n.inp -o pipe.h5 --force
expect 2 "pipe" "$limber" run n.inp -o pipe.h5 --restart
rm pipe.h5
expect 2 "pipe.checkpoint.h5" "$limber" run n.inp -o pipe.h5
expect 2 "pipe.checkpoint.h5" "$limber" run n.inp -o pipe.h5 --restart
printf '%s\n*STUDY, REFERENCE=pipe\n' "$deck" > study.inp
expect 2 "pipe is not" "$limber" study study.inp

# A bit of a checkpoint, or of the samples so far, that has changed: refused, or without an effect; and then nothing is touched.
# (A byte with no meaning may change.) All bytes of a small one: test_checkpoint
sed 's/END=1, OUTPUTS=4/END=1e6, OUTPUTS=1000000/' n.inp > long.inp
"$limber" run long.inp --quiet -o run.h5 --checkpoint 0.05 > messages 2>&1 &
process=$!
tries=0
while [ ! -e run.checkpoint.h5 ] && [ $tries -lt 400 ]; do tries=$((tries + 1)); sleep 0.05; done
kill -TERM $process
wait $process
[ $? -eq 4 ] || complain "a long run"
cp run.h5 good.h5
cp run.checkpoint.h5 good.checkpoint.h5
size=$(wc -c < good.checkpoint.h5)
refused=0
told=0
for i in 1 2 3 4 5 6 7 8 9 10 11 12; do
  at=$((size*(2*i - 1)/24))
  byte=$(od -An -tu1 -j $at -N 1 good.checkpoint.h5)
  cp good.checkpoint.h5 run.checkpoint.h5
  printf "\\$(printf %o $((byte ^ 16)))" | dd of=run.checkpoint.h5 bs=1 seek=$at conv=notrunc 2> /dev/null
  cp run.checkpoint.h5 damaged
  # One that is not refused goes on: it has done so when it replaces the checkpoint
  "$limber" run long.inp --quiet -o run.h5 --restart --checkpoint 0.05 > messages 2>&1 &
  process=$!
  tries=0
  while kill -0 $process 2> /dev/null && cmp -s run.checkpoint.h5 damaged && [ $tries -lt 400 ]; do
    tries=$((tries + 1))
    sleep 0.05
  done
  kill -TERM $process 2> /dev/null
  wait $process
  status=$?
  case $status in
    2 | 3)
      refused=$((refused + 1))
      ! grep -q 'no reason given' messages || complain "byte $at: refused without a reason: $(cat messages)"
      grep -q 'is damaged: .*--force without --restart begins anew' messages && told=$((told + 1))
      cmp -s run.h5 good.h5 || complain "byte $at: the results were touched"
      cmp -s run.checkpoint.h5 damaged || complain "byte $at: the checkpoint was touched"
      [ ! -e run.h5.running ] || complain "byte $at: run.h5.running is left" ;;
    4) cp good.h5 run.h5; rm -f run.h5.running ;;
    *) complain "byte $at: status $status" ;;
  esac
done
[ $told -ge 1 ] || complain "of no damaged checkpoint it is said that it is, and what to do"
[ $refused -ge 3 ] || complain "only $refused of 12 damaged checkpoints are refused"
cp good.checkpoint.h5 run.checkpoint.h5
cp good.h5 run.h5
size=$(wc -c < run.h5)
at=$((size*2/3))
byte=$(od -An -tu1 -j $at -N 1 run.h5)
printf "\\$(printf %o $((byte ^ 16)))" | dd of=run.h5 bs=1 seek=$at conv=notrunc 2> /dev/null
note run.h5
expect 2 "damaged\|cannot be continued; it was left as it is" "$limber" run long.inp --quiet -o run.h5 --restart
keeps run.h5
[ ! -e run.h5.running ] || complain "run.h5.running is left"
[ $failed -eq 0 ] && echo 'all as it should be'
exit $failed
