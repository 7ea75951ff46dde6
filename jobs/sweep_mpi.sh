#!/bin/bash
# A sweep as one parallel job: each rank runs its part of the rows. Rows need no messages, so limber needs no MPI library: it asks
# the launcher (srun, mpirun of Open MPI or MPICH) which rank it is.
#
#   sbatch --ntasks=64 jobs/sweep_mpi.sh DECK [SUMMARY]
#SBATCH --job-name=limber-sweep
#SBATCH --ntasks=2
#SBATCH --time=01:00:00
#SBATCH --output=%x-%j.log
set -u
# A name that begins with a dash is no option
deck=$1
case $deck in -*) deck=./$deck ;; esac
name=${deck##*/}
summary=${2:-${name%.*}.sweep.h5}
limber=${LIMBER:-limber}
srun --kill-on-bad-exit=0 "$limber" sweep "$deck" -o "$summary" --part auto --jobs 1 --quiet
exec "$limber" sweep "$deck" -o "$summary" --collect
