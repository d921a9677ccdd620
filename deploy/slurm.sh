#!/bin/sh
# Bakes a world as an array of jobs: sbatch --array=0-63 deploy/slurm.sh PLAN STORE
# The number of jobs and each job's own come from Slurm. Run the same again to bake what is missing: what is there costs nothing.
# To run only some of the jobs again, set ARGIL_SHARDS to the number of all: ARGIL_SHARDS=64 sbatch --array=3,17 ...
#SBATCH --job-name=argil-bake
#SBATCH --cpus-per-task=2
#SBATCH --mem=2G
#SBATCH --time=02:00:00
#SBATCH --requeue
set -eu

if [ "$#" -ne 2 ]; then
    echo "usage: sbatch --array=0-N $0 PLAN STORE" >&2
    exit 2
fi
exec argil world bake "$1" --store "$2" --threads "${SLURM_CPUS_PER_TASK:-2}" ${ARGIL_SHARDS:+--shards "$ARGIL_SHARDS"}
