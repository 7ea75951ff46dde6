#!/usr/bin/env bash
# Runs the scripts of jobs/ on a Slurm of one node that is started for the purpose: a sweep as a job array and as a parallel job
# must give the summary of the local one to the bit, and a run in pieces the bits of one without a warning.
#   slurm.sh LIMBER DECK JOBS WORK      status 77: there is no Slurm here, or no right to start it
set -euo pipefail
limber=$1 deck=$2 jobs=$3 work=$4
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
  for _ in $(seq 600); do
    [[ -z $(squeue -h) ]] && return
    sleep 0.2
  done
  echo "jobs do not end"; squeue; exit 1
}

sed 's/10:105:20/10:105:5/' "$deck" > deck.inp
export LIMBER=$limber
"$limber" sweep deck.inp --jobs 2 -o local.h5 --quiet
array=$(sbatch --parsable --array=1-3 "$jobs/sweep_array.sh" deck.inp array.h5)
sbatch --dependency=afterany:"$array" "$jobs/sweep_collect.sh" deck.inp array.h5 >/dev/null
await
sbatch "$jobs/sweep_mpi.sh" deck.inp ranks.h5 >/dev/null
await
cat ./*.log | grep -v "^\[" | tail -20
for summary in array ranks; do
  [[ $(ls $summary.rows/*.journal | wc -l) -ge 2 ]] || { echo "$summary was not run by several processes"; exit 1; }
  "$limber" diff $summary.h5 local.h5 --rtol 0 --range 0
done

# A run that is warned twice puts itself into the queue again, and ends with the bits of one that was not
sed 's/turns = 2/turns = 16/; s/OUTPUTS=838/OUTPUTS=8380/' "$(dirname "$deck")/slider_crank_full.inp" > long.inp
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
