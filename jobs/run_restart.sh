#!/bin/bash
# One long run in pieces: before its time is over Slurm warns it, limber writes a checkpoint and leaves, and the job puts itself into
# the queue again, until the run has reached its end.
#
#   sbatch --time=04:00:00 jobs/run_restart.sh DECK [RESULTS]
#
# A run that was killed without a warning (a node that fails, scancel --signal=KILL) goes on from its last checkpoint when the
# job is submitted again; one that is complete says so. A run that fails, or that cannot go on, is not repeated.
#SBATCH --job-name=limber-run
#SBATCH --cpus-per-task=1
#SBATCH --time=01:00:00
#SBATCH --signal=B:USR1@120
#SBATCH --requeue
#SBATCH --open-mode=append
#SBATCH --output=%x-%j.log
set -u
# A name that begins with a dash is no option
deck=$1
case $deck in -*) deck=./$deck ;; esac
name=${deck##*/}
results=${2:-${name%.*}.h5}
read -ra options <<< "${LIMBER_OPTIONS:-}"
"${LIMBER:-limber}" run "$deck" -o "$results" --restart --quiet "${options[@]}" &
run=$!
# Slurm warns this script only: it passes the signal on, and waits for the run once more, for the first wait ends with the signal
warned=
trap 'warned=yes; kill -USR1 $run 2> /dev/null' USR1 TERM INT
wait $run
status=$?
while [[ -n $warned ]]; do
  warned=
  wait $run
  status=$?
done
# 4: interrupted; with a checkpoint it can go on, but the search for a TARGET would begin anew each time
if [[ $status -eq 4 && -e ${results%.h5}.checkpoint.h5 ]]; then
  scontrol requeue "$SLURM_JOB_ID"
  exit 0
fi
exit $status
