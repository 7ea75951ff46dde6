#!/bin/sh
# Runs killed with -9 at random moments: after each kill the file of results opens and has no sample less than before, all of them to the
# bit; in the end the run has the bits of one that was left alone.
#   tests/kill.sh LIMBER INPUT WORK [RUNS [SEED]]
# RUNS (200) runs over several decks and integrators are killed, each one to three times, and then let go on to their ends. The last
# line counts them; status 1 if one was not as it should be.
limber=$1
input=$2
work=$3
runs=${4:-200}
seed=${5:-1}
rm -rf "$work"
mkdir -p "$work" || exit 1
cd "$work" || exit 1

# Decks and what is changed in them: about half a second each
count=0
deck() {
  count=$((count + 1))
  sed "$2" "$input/$1.inp" > $count.inp
}
for integrator in ADAMS RADAU ALPHA CONSERVING; do
  deck slider_crank_exact "s/turns = 2/turns = 3/; s/TOLERANCE=1e-8, OUTPUTS=838/TOLERANCE=1e-5, OUTPUTS=838, INTEGRATOR=$integrator/"
  deck andrews_squeezer "s/TOLERANCE=1e-8, OUTPUTS=300, INTEGRATOR=ADAMS/TOLERANCE=1e-10, OUTPUTS=3000, MAXIMUM STEP=1e-5, INTEGRATOR=$integrator/"
done
deck chain_flexible "s/N = 100/N = 30/; s/OUTPUTS=100/OUTPUTS=400/"
deck rotating_cantilever "s/rise = 12/rise = 4/; s/END=24, OUTPUTS=2400/END=10, OUTPUTS=1000/"
deck cantilever_statics "s/INCREMENTS=4\$/INCREMENTS=300/; s/END=3, OUTPUTS=10/END=3, OUTPUTS=300, TOLERANCE=1e-9/"
deck slider_crank_exact 's/turns = 2/turns = 1/; s/^\*DYNAMICS.*/*DYNAMICS, END=turns*2*pi\/speed, TOLERANCE=1e-6, OUTPUTS=400\
*DYNAMICS, END=2*turns*2*pi\/speed, TOLERANCE=1e-7, OUTPUTS=400/'
deck portal_frame "s/TOLERANCE=1e-7/TOLERANCE=1e-9/"
deck whipped_frame "s/TOLERANCE=1e-5/TOLERANCE=1e-8/"
deck spin_up "s/STRAIN FUNCTIONS=2/STRAIN FUNCTIONS=0/; s/TOLERANCE=1e-8/TOLERANCE=1e-10/"
deck flexible_four_bar 's/rise = 0.4/rise = 0.02/; s/TOLERANCE=1e-6/&\
*ACCURACY, ESTIMATE=YES/; s/TOLERANCE=1e-6/TOLERANCE=1e-5/'

# Whole runs, and the seconds that they take; no more decks than runs
[ $count -le $runs ] || count=$runs
: > seconds
k=1
while [ $k -le $count ]; do
  start=$(date +%s.%N)
  "$limber" run $k.inp --quiet -o whole$k.h5 > messages 2>&1 || { echo "deck $k:"; cat messages; exit 1; }
  echo "$start $(date +%s.%N)" | awk '{ print $2 - $1 }' >> seconds
  "$limber" export whole$k.h5 > whole$k.txt || exit 1
  k=$((k + 1))
done

# Which deck, how often, at what parts of its time, and how often a checkpoint is written
awk -v runs=$runs -v seed=$seed -v count=$count 'BEGIN {
  while ((getline line < "seconds") > 0) seconds[++n] = line
  srand(seed)
  for (i = 1; i <= 10*runs; i++) {
    k = (i - 1)%count + 1
    line = k " " (rand() < 0.5 ? 0.01 : 0.1)
    m = 1 + int(3*rand())
    for (j = 1; j <= m; j++) line = line " " rand()*seconds[k]
    print line
  } }' > plan

failures=0
kills=0
killed=0
fail() {
  echo "run $number (deck $k): $*"
  cat messages
  failures=$((failures + 1))
}
number=0
while [ $killed -lt $runs ] && read -r k interval moments; do
  number=$((number + 1))
  rm -f run.*
  had=0
  good=yes
  before=$kills
  for moment in $moments; do
    "$limber" run $k.inp --quiet --restart --checkpoint $interval -o run.h5 > messages 2>&1 &
    process=$!
    sleep $moment
    kill -9 $process 2> /dev/null && kills=$((kills + 1))
    wait $process 2> /dev/null
    [ -e run.h5 ] || continue
    "$limber" export run.h5 > run.txt 2> messages || { fail "does not open"; good=no; break; }
    has=$(wc -l < run.txt)
    [ $has -ge $had ] || { fail "$has lines, $had before"; good=no; break; }
    had=$has
    # The estimates of a finished run stand in columns of their own
    sed '1d; s/ *$//' run.txt > samples
    sed '1d; s/ *$//' whole$k.txt | head -n $((has - 1)) | cmp -s - samples && continue
    width=$(sed -n 2p run.txt | wc -w)
    sed 1d whole$k.txt | head -n $((has - 1)) | awk -v n=$width '{ for (i = 1; i <= n; i++) printf "%s ", $i; print "" }' > wanted
    awk '{ for (i = 1; i <= NF; i++) printf "%s ", $i; print "" }' run.txt | sed 1d | cmp -s - wanted && continue
    fail "other samples"
    good=no
    break
  done
  [ $kills -gt $before ] && killed=$((killed + 1))
  [ $good = yes ] || continue
  "$limber" run $k.inp --quiet --restart --checkpoint $interval -o run.h5 > messages 2>&1 || { fail "does not go on"; continue; }
  "$limber" diff run.h5 whole$k.h5 --rtol 0 --range 0 > messages 2>&1 || { fail "other bits"; continue; }
  [ "$(ls run.* | tr '\n' ' ')" = "run.h5 run.txt " ] || [ "$(ls run.* | tr '\n' ' ')" = "run.h5 " ] || fail "leaves $(ls run.*)"
done < plan
echo "$number runs, $killed of them killed, $kills kills, $failures failures"
[ $failures -eq 0 ] && [ $killed -eq $runs ]
