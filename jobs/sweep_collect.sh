#!/bin/bash
# The summary of a sweep whose rows other jobs have run: see sweep_array.sh and sweep_mpi.sh.
#SBATCH --job-name=limber-collect
#SBATCH --time=00:10:00
#SBATCH --output=%x-%j.log
set -u
deck=$1
summary=${2:-$(basename "${deck%.*}").sweep.h5}
exec "${LIMBER:-limber}" sweep "$deck" -o "$summary" --collect
