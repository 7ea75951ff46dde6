#!/bin/bash
# A sweep as a job array: each task runs its part of the rows, on as many processors as it has.
#
#   sbatch --array=1-16 jobs/sweep_array.sh DECK [SUMMARY]
#   sbatch --dependency=afterany:<number of that job> jobs/sweep_collect.sh DECK [SUMMARY]
#
# Submitted again, it runs only rows that are missing or have failed. All tasks need to see the folder of the job.
#SBATCH --job-name=limber-sweep
#SBATCH --cpus-per-task=1
#SBATCH --time=01:00:00
#SBATCH --output=%x-%A_%a.log
set -u
# A name that begins with a dash is no option
deck=$1
case $deck in -*) deck=./$deck ;; esac
name=${deck##*/}
summary=${2:-${name%.*}.sweep.h5}
exec "${LIMBER:-limber}" sweep "$deck" -o "$summary" --part auto --quiet
