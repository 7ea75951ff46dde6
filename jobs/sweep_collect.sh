#!/bin/bash
# The summary of a sweep whose rows other jobs have run: see sweep_array.sh and sweep_mpi.sh.
#SBATCH --job-name=limber-collect
#SBATCH --time=00:10:00
#SBATCH --output=%x-%j.log
set -u
# A name that begins with a dash is no option
deck=$1
case $deck in -*) deck=./$deck ;; esac
name=${deck##*/}
summary=${2:-${name%.*}.sweep.h5}
exec "${LIMBER:-limber}" sweep "$deck" -o "$summary" --collect
