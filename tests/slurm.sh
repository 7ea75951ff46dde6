#!/usr/bin/env bash
# Runs the scripts of jobs/ on a Slurm of one node that is started for the purpose: a sweep as a job array and as a parallel job
# must give the summary and the histories of the local one to the bit, rows that fail with their reasons among them, and a run in
# pieces the bits of one without a warning.
#   slurm.sh LIMBER DECK JOBS WORK [ROWS [TASKS]]     status 77: there is no Slurm here, or no right to start it
# The test has 20 rows (one of 20 is refused, one fails in its run) in an array of 3 tasks. Some minutes take
#   tests/slurm.sh "$PWD"/build/release/limber input/sweep_speed.inp "$PWD"/jobs /tmp/slurm 1000 40
set -euo pipefail
limber=$1 deck=$(realpath "$2") jobs=$(realpath "$3") work=$4 rows=${5:-20} tasks=${6:-3}
for program in munged slurmctld slurmd sbatch; do
  PATH=$PATH:/usr/sbin command -v $program >/dev/null || { echo "no $program"; exit 77; }
done
[[ $EUID -eq 0 ]] || { echo "slurmd must be started by root"; exit 77; }
export PATH=$PATH:/usr/sbin
rm -rf "$work"; mkdir -p "$work"; cd "$work"
# Sockets need short paths
short=$(mktemp -d)
processes=()
finish() {
  [[ ${#processes[@]} -eq 0 ]] || kill "${processes[@]}" 2>/dev/null || true
  wait 2>/dev/null || true
  rm -rf "$short"
}
trap finish EXIT

host=$(hostname -s)
dd if=/dev/urandom of=munge.key bs=1024 count=1 status=none
chmod 700 "$work"; chmod 755 "$short"; chmod 600 munge.key
munged --force --foreground --num-threads=2 --key-file="$work/munge.key" --socket="$short/munge" --pid-file="$short/munge.pid" \
  --log-file="$work/munge.log" --seed-file="$work/munge.seed" 2>/dev/null & processes+=($!)
port=$((20000 + RANDOM % 10000))
cat > slurm.conf <<TEXT
ClusterName=limber
SlurmctldHost=$host(127.0.0.1)
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket=$short/munge,cred_expire=5
CryptoType=crypto/munge
SlurmctldPort=$port
SlurmdPort=$((port + 1))
StateSaveLocation=$work/state
SlurmdSpoolDir=$work/spool
SlurmctldPidFile=$short/ctld.pid
SlurmdPidFile=$short/d.pid
SlurmctldLogFile=$work/slurmctld.log
SlurmdLogFile=$work/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SwitchType=switch/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
ReturnToService=2
SchedulerParameters=sched_interval=1,batch_sched_delay=0,defer_batch
MinJobAge=300
NodeName=$host NodeAddr=127.0.0.1 CPUs=2 State=UNKNOWN
PartitionName=all Nodes=$host Default=YES MaxTime=INFINITE State=UP OverSubscribe=NO
TEXT
mkdir state spool
export SLURM_CONF=$work/slurm.conf
for _ in $(seq 50); do [[ -S $short/munge ]] && break; sleep 0.1; done
slurmctld -D -c >/dev/null 2>&1 & processes+=($!)
slurmd -D -c -N "$host" >/dev/null 2>&1 & processes+=($!)
for _ in $(seq 100); do
  sinfo -h -o %T 2>/dev/null | grep -q idle && break
  sleep 0.2
done
sinfo -h -o %T | grep -q idle || { echo "the node does not come up"; tail -5 slurmctld.log slurmd.log; exit 1; }

await() {  # until no job is left
  for _ in $(seq $((600 + 5*rows))); do
    [[ -z $(squeue -h) ]] && return
    sleep 0.2
  done
  echo "jobs do not end"; squeue; exit 1
}

# A wire of minus a millimetre is refused, one of 0.05 mm deflects by more than its length
awk -v rows="$rows" 'BEGIN {
  print "speed, diameter"
  for (i = 1; i <= rows; i++)
    print 10 + 95*(i - 1)/rows ", " (i%20 == 7 ? "-1e-3" : i%20 == 14 ? "5e-5" : 6 + 2*(i%4) "e-3")
}' > cases.csv
sed '/^\*SWEEP/,$d' "$deck" > deck.inp
echo '*SWEEP, FILE="cases.csv", KEEP=YES' >> deck.inp
export LIMBER=$limber
SECONDS=0
"$limber" sweep deck.inp --jobs 2 -o local.h5 --quiet > local.log 2>&1 || [[ $? -eq 3 ]]
echo "local sweep: $SECONDS s; $(head -1 local.log)"
# Rows that fail say why, the others have their histories
refused=$(((rows + 13)/20)) failed=$(((rows + 6)/20))
if [[ $(grep -c ',refused,.*DIAMETER must be greater than 0, not -0.001' local.csv) -ne $refused ||
  $(grep -c ",failed,.*beam 'rod' deflects by more than its length at t = " local.csv) -ne $failed ||
  $(grep -c ',ok,' local.csv) -ne $((rows - refused - failed)) || $(ls local.rows/*.h5 | wc -l) -ne $((rows - refused)) ]]; then
  echo "not $refused rows refused, $failed failed, all others with a history"; cut -c 1-200 local.csv | tail -20; exit 1
fi
SECONDS=0
array=$(sbatch --parsable --array=1-"$tasks" "$jobs/sweep_array.sh" deck.inp array.h5)
sbatch --dependency=afterany:"$array" "$jobs/sweep_collect.sh" deck.inp array.h5 >/dev/null
await
echo "array of $tasks tasks, and the summary: $SECONDS s"
SECONDS=0
sbatch "$jobs/sweep_mpi.sh" deck.inp ranks.h5 >/dev/null
await
echo "parallel job: $SECONDS s"
grep -hv "^\[" limber-collect-*.log | head -5
# But for the seconds and the folder the tables are the same letter by letter
table() { cut -d , -f 1-5,7- "$1.csv" | sed "s:$1\.rows/:rows/:g; s:$1\.h5:summary.h5:g"; }
for summary in array ranks; do
  [[ $(ls $summary.rows/*.journal | wc -l) -ge 2 ]] || { echo "$summary was not run by several processes"; exit 1; }
  "$limber" diff $summary.h5 local.h5 --rtol 0 --range 0
  table local | cmp - <(table $summary)
  count=0
  for history in local.rows/*.h5; do
    "$limber" diff $summary.rows/"${history##*/}" "$history" --rtol 0 --range 0 > difference || { cat difference; exit 1; }
    count=$((count + 1))
  done
  [[ $(ls $summary.rows/*.h5 | wc -l) -eq $count ]] || { echo "$summary has other histories"; exit 1; }
  echo "$count histories of $summary are those of the local sweep"
done

# A run that is warned twice puts itself into the queue again, and ends with the bits of one that was not
sed 's/turns = 2/turns = 16/; s/OUTPUTS=838/OUTPUTS=8380/' "$(dirname "$deck")/slider_crank_exact.inp" > long.inp
"$limber" run long.inp --quiet -o whole.h5
export LIMBER_OPTIONS="--checkpoint 0.2"
run=$(sbatch --parsable "$jobs/run_restart.sh" long.inp pieces.h5)
# Slurm would wait two minutes before it starts a job again, since credentials of the second in which it was ended are refused
hurry() { scontrol update JobId="$run" StartTime=now >/dev/null 2>&1 || true; }
for warning in 1 2; do
  for _ in $(seq 600); do
    [[ -e pieces.h5.running ]] && break
    hurry
    sleep 0.1
  done
  sleep 0.3
  scancel --batch --signal=USR1 "$run"
  for _ in $(seq 100); do
    [[ -e pieces.h5.running ]] || break
    sleep 0.1
  done
  [[ ! -e pieces.h5.running ]] || { echo "warning $warning was not heeded"; exit 1; }
  sleep 3
done
# Between two parts the queue may look empty for a moment
for _ in $(seq 600); do
  [[ -e pieces.checkpoint.h5 || -e pieces.h5.running ]] || break
  hurry
  sleep 0.1
done
await
cat "limber-run-$run.log"
[[ $(grep -c "interrupted by SIGUSR1 .* goes on from there with --restart" "limber-run-$run.log") -eq 2 ]] || { echo "not interrupted twice"; exit 1; }
"$limber" diff pieces.h5 whole.h5 --rtol 0 --range 0
