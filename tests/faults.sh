#!/bin/sh
# What may go wrong with the place where results go: a full disk, one without room for a copy, a folder that is read-only, one that
# vanishes. Each has a message and a status, nothing that was written is lost, and nothing is overwritten.
#   tests/faults.sh LIMBER INPUT WORK [TURNS]
# Needs the right to mount small file systems in memory; without it a limit on the size of files stands for the full disk, what cannot be
# tried is named, and the status is 77. TURNS (20) of the slider-crank are run: some tenths of a second.
limber=$1
input=$2
work=$3
turns=${4:-20}
# Left by a run that was killed
umount "$work/disk" 2> /dev/null
rm -rf "$work"
mkdir -p "$work/disk" || exit 1
cd "$work" || exit 1
skipped=0
trap 'cd /; umount "$work/disk" 2> /dev/null' EXIT

# expect STATUS TEXT COMMAND...: TEXT is in what the command says
expect() {
  wanted=$1
  text=$2
  shift 2
  "$@" > "$work/messages" 2>&1
  status=$?
  if [ $status -ne "$wanted" ] || ! grep -q "$text" "$work/messages"; then
    echo "$*: status $status for $wanted; '$text' in:"
    cat "$work/messages"
    exit 1
  fi
}
# limited BLOCKS COMMAND...: its files may not grow beyond so many blocks of 512 bytes. In a build for coverage the counts of lines
# are cut off too: they go where nobody looks, or those of all tests are spoiled, and what is said of it would fill the messages
limited() {
  (
    ulimit -f "$1"
    shift
    export GCOV_PREFIX="$work/counts" GCOV_ERROR_FILE=/dev/null
    exec "$@"
  )
}
# awaits FILE: it is there, within a minute, or the run in $process has ended
awaits() {
  tries=0
  while [ ! -e "$1" ] && kill -0 $process 2> /dev/null && [ $tries -lt 6000 ]; do tries=$((tries + 1)); sleep 0.01; done
}
same() { expect 0 "the same" "$limber" diff "$1" "$work/whole.h5" --rtol 0 --range 0; }
# What a results file holds is the beginning of the whole
begins() {
  "$limber" export "$1" > "$work/part.txt" || exit 1
  if ! head -n "$(wc -l < "$work/part.txt")" "$work/whole.txt" | cmp -s - "$work/part.txt"; then
    echo "$1 has other samples"
    exit 1
  fi
}

sed "s/TOLERANCE=1e-8, OUTPUTS=838/TOLERANCE=1e-5, OUTPUTS=20000/; s/turns = 2/turns = $turns/" "$input/slider_crank_exact.inp" > deck.inp
expect 0 "20001 samples" "$limber" run deck.inp -o whole.h5
sed "s/turns = $turns/turns = ${turns}00/; s/OUTPUTS=20000/OUTPUTS=200000/" deck.inp > long.inp
"$limber" export whole.h5 > whole.txt
size=$(wc -c < whole.h5)

# A sweep whose journals, histories, summary or table find no room: what is done stays done, nothing that is cut off takes a name, and
# once there is room the sweep goes on
sed '/^\*SWEEP/,$d; s/END=2\*2\*pi/END=0.2/; s/TOLERANCE=1e-6, OUTPUTS=400/TOLERANCE=1e-4, OUTPUTS=20/' "$input/sweep_speed.inp" > sweep.inp
printf '*SWEEP\n speed, 10:105:100\n diameter, 8e-3\n' >> sweep.inp
table() { cut -d , -f 1-5,7-9,11- "$1"; }
expect 0 "100 rows: 100 ok" "$limber" sweep sweep.inp --jobs 2 --keep -o sweep.h5
table sweep.csv > wanted.csv
sweep() { "$limber" sweep "$work/sweep.inp" --jobs 2 --quiet -o swept.h5 "$@"; }
swept() {
  expect 0 "the same" "$limber" diff swept.h5 "$work/sweep.h5" --rtol 0 --range 0
  table swept.csv | cmp - "$work/wanted.csv" || exit 1
}
# As many rows are done as were said to be. Where one journal takes all the room the other process may end the sweep before it has a row
goes_on() {
  done=$(sed -n 's/^ *\([0-9]*\) of 100 rows are done and are kept in swept.rows; called again, .*/\1/p' "$work/messages")
  [ "${done:-0}" -gt 0 ] || [ "$1" = 4 ] || { echo "no row is done"; exit 1; }
  [ "$(echo swept*)" = swept.rows ] || { echo "there are $(echo swept*)"; exit 1; }
  [ -z "$1" ] || mount -o remount,size=20m .
  before="^$done rows were done already"
  [ "${done:-0}" -gt 0 ] || before="100 rows: 100 ok"
  expect 0 "$before" "$limber" sweep "$work/sweep.inp" --jobs 2 -o swept.h5
  swept
}

# A deck with the choices of an advice that finds no room: what has its name stays, and nothing is beside it
unwritten() {
  expect 2 "advised.inp: cannot be written" "$@" "$limber" advise "$work/deck.inp" --write advised.inp --force
  [ "$(cat advised.inp)" = before ] && [ "$(echo advised.inp*)" = advised.inp ] || { echo "advised.inp is not as it was"; exit 1; }
}

# A disk that fills up while the run goes on: what was safe stays, and once there is room the run goes on
full() {
  expect 3 "full.h5 has the first [0-9]* samples, marked incomplete; more could not be written" "$@"
  begins full.h5
  [ ! -e full.h5.running ] || { echo "full.h5.running is left"; exit 1; }
}
if mount -t tmpfs -o size=300k tmpfs disk 2> /dev/null; then
  cd disk || exit 1
  full "$limber" run ../deck.inp --quiet -o full.h5 --checkpoint 0.005
  cp full.h5 full.checkpoint.h5 ..
  full "$limber" run ../deck.inp --quiet -o full.h5 --checkpoint 0.02 --restart
  mount -o remount,size=20m .
  expect 0 "continued at" "$limber" run ../deck.inp -o full.h5 --restart
  same full.h5

  # Interrupted while it is full: it goes on from the last checkpoint that found room. A fast machine may have to write samples
  # before that, which ends the run
  rm -f full*
  mount -o remount,size=400k .
  "$limber" run ../long.inp --quiet -o full.h5 --checkpoint 0.005 > ../messages 2>&1 &
  process=$!
  awaits full.checkpoint.h5
  # More than once: the run itself gives room free now and then
  for i in 1 2 3 4 5 6; do
    head -c 400000 /dev/zero > rest$i 2> /dev/null
    sleep 0.03
  done
  kill -TERM $process
  wait $process
  status=$?
  if ! { [ $status -eq 4 ] && grep -q "with --restart it goes on from t = .*no checkpoint could be written since: " ../messages; } &&
    ! { [ $status -eq 3 ] && grep -q "No space left on device" ../messages; }; then
    echo "interrupted on a full disk: status $status"; cat ../messages; exit 1
  fi
  "$limber" export full.h5 > ../part.txt || exit 1

  # No room for anything at all, and none to go on
  cp full.h5 full.checkpoint.h5 ..
  head -c 400000 /dev/zero > rest7 2> /dev/null
  expect 2 "cannot copy full.h5 to full.h5.running: " "$limber" run ../long.inp --quiet -o full.h5 --restart
  cmp full.h5 ../full.h5 && cmp full.checkpoint.h5 ../full.checkpoint.h5 || exit 1
  expect 2 "cannot create none.h5.running: No space left on device" "$limber" run ../deck.inp --quiet -o none.h5
  [ ! -e none.h5 ] && [ ! -e none.h5.running ] || { echo "none.h5 is left"; exit 1; }

  rm -f full* rest?
  echo before > advised.inp
  head -c 500000 /dev/zero > rest7 2> /dev/null
  unwritten

  # Room for the file and the copy before, but not for another one: the run reaches its end all the same
  rm -f rest7 advised.inp
  mount -o remount,size=$((size*9/5)) .
  expect 0 "warning: the last checkpoint could not be written: No space left on device" "$limber" run ../deck.inp -o tight.h5 --checkpoint 0.005
  same tight.h5
  rm -f tight*
  mount -o remount,size=20m .

  for size in 4 8 20 48; do
    mount -o remount,size=${size}k .
    expect 3 "takes no more rows: is the disk full?\|the summary could not be written: .*: No space left on device" sweep
    goes_on $size
    rm -rf swept*
  done
  # Room for the results file, but not for the table; never a part of either
  sweep || exit 1
  cp -r swept.rows ..
  found=0
  for size in 48 52 56 60 64 68 72 76 80 84 88 92; do
    rm -rf swept*
    mount -o remount,size=${size}k .
    cp -r ../swept.rows .
    sweep > ../messages 2>&1
    status=$?
    if [ $status -eq 0 ]; then
      swept
    elif [ $status -ne 3 ] || [ "$(echo swept*)" != swept.rows ]; then
      echo "$size kB: status $status, $(echo swept*)"; cat ../messages; exit 1
    elif grep -q "the summary could not be written: cannot write swept.csv.new: is the disk full?" ../messages; then
      found=1
    fi
  done
  [ $found -eq 1 ] && [ $status -eq 0 ] || { echo "no table was too long, or all were"; exit 1; }
  # A summary that is there stays as it is when another one finds no room
  cp swept.h5 swept.csv ..
  head -c 1000000 /dev/zero > rest 2> /dev/null
  expect 3 "is the disk full?\|No space left on device" sweep --set speed=10:105:200
  cmp swept.h5 ../swept.h5 && cmp swept.csv ../swept.csv || exit 1
  rm -rf swept* rest
  # Histories that find no room make their rows fail, until there is some
  mount -o remount,size=400k .
  expect 3 "No space left on device\|takes no more rows: is the disk full?" sweep --keep
  mount -o remount,size=20m .
  expect 0 "rows were done already" "$limber" sweep "$work/sweep.inp" --jobs 2 --keep -o swept.h5
  swept
  for history in swept.rows/*.h5; do
    expect 0 "the same" "$limber" diff $history ../sweep.rows/${history##*/} --rtol 0 --range 0
  done
  [ "$(ls swept.rows/*.h5 | wc -l)" -eq 100 ] || { echo "not all histories are there"; exit 1; }
  rm -rf swept*

  # A folder that is read-only: nothing can be made, and what is there is left as it is
  for try in 1 2 3 4 5; do
    rm -f fixed*
    "$limber" run ../deck.inp --quiet -o fixed.h5 --checkpoint 0.005 > ../messages 2>&1 &
    process=$!
    awaits fixed.checkpoint.h5
    kill -9 $process 2> /dev/null
    wait $process 2> /dev/null
    # Too late where it has come to its end and needs none
    [ ! -e fixed.checkpoint.h5 ] || break
  done
  [ -e fixed.checkpoint.h5 ] || { echo "no checkpoint of a run is seen"; exit 1; }
  cp fixed.h5 fixed.checkpoint.h5 ..
  mount -o remount,ro .
  expect 2 "cannot create new.h5.running: Read-only file system" "$limber" run ../deck.inp --quiet -o new.h5
  expect 2 "cannot overwrite fixed.h5: Permission denied" "$limber" run ../deck.inp --quiet -o fixed.h5 --force
  expect 2 "fixed.h5" "$limber" run ../deck.inp --quiet -o fixed.h5 --restart
  cmp fixed.h5 ../fixed.h5 && cmp fixed.checkpoint.h5 ../fixed.checkpoint.h5 || exit 1
  mount -o remount,rw .
  expect 0 "continued at" "$limber" run ../deck.inp -o fixed.h5 --restart
  same fixed.h5
  cd ..
  umount disk
else
  echo "skipped: mounting is not permitted here: a real full disk, one without room for a copy, a read-only file system"
  skipped=1
  # A file that may not grow: 200 blocks of 512 bytes
  full limited 200 "$limber" run deck.inp --quiet -o full.h5 --checkpoint 0.02
  expect 0 "continued at" "$limber" run deck.inp -o full.h5 --restart
  same full.h5
  expect 3 "takes no more rows: is the disk full?" limited 8 "$limber" sweep sweep.inp --jobs 2 --quiet -o swept.h5
  goes_on
  echo before > advised.inp
  unwritten limited 1
fi

# A folder without the right to write, for those whom that stops
mkdir locked
chmod 500 locked
if touch locked/probe 2> /dev/null; then
  echo "not tried: a folder without the right to write (this user may write anywhere)"
else
  expect 2 "cannot create locked/a.h5.running: Permission denied" "$limber" run deck.inp --quiet -o locked/a.h5
fi

# A folder that vanishes, and one that is not there
mkdir gone
"$limber" run long.inp --quiet -o gone/a.h5 --checkpoint 0.02 > messages 2>&1 &
process=$!
awaits gone/a.checkpoint.h5
mv gone elsewhere
wait $process
status=$?
if [ $status -ne 3 ] || ! grep -q "gone/a.h5.running is gone: somebody has removed it, or its folder" messages; then
  echo "a folder that vanishes: status $status"; cat messages; exit 1
fi
"$limber" export elsewhere/a.h5 > /dev/null || exit 1
number=$(ls -i elsewhere/a.checkpoint.h5)
expect 4 "interrupted" sh -c "'$limber' run long.inp --quiet -o elsewhere/a.h5 --restart --checkpoint 0.02 & p=\$!
  while [ \"\$(ls -i elsewhere/a.checkpoint.h5)\" = '$number' ] && kill -0 \$p; do sleep 0.02; done; kill -TERM \$p; wait \$p"
expect 2 "cannot create gone/a.h5.running: No such file or directory" "$limber" run deck.inp --quiet -o gone/a.h5
[ $skipped -eq 0 ] || exit 77
echo "all as it should be"
