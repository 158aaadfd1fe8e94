#!/usr/bin/env bash
# Runs a plan as a Slurm array, then merges the shards' stores, then writes the report:
#   submit.sh SHARDS FOLDER PILOT PLAN [OPTION...]
# FOLDER is for the stores, on a file system that all nodes see. PILOT is the store of a small run of the same plan; time
# limit and memory come from it. OPTION... are options of `lcpbench run`. The same command again runs what is missing.
# THREADS is the number of threads of a shard (1).
set -euo pipefail
here=$(dirname "$(realpath "$0")")
shards=$1 folder=$(realpath -m "$2") pilot=$(realpath "$3")
shift 3
lcpbench=$(command -v lcpbench)
threads=${THREADS:-1}
mkdir -p "$folder"

list=$("$lcpbench" run "$@" --jobs "$threads" --list-shards "$shards" --costs "$pilot" \
         --store "$folder/shard-{}.db" --format json)
array=$(sed -n 's/^  "array": "\(.*\)",$/\1/p' <<< "$list")
minutes=$(sed -n 's/^  "minutes": \([0-9]*\),$/\1/p' <<< "$list")
megabytes=$(sed -n 's/^  "megabytes": \([0-9]*\),$/\1/p' <<< "$list")

submit() {  # TASK OPTION... -- ARGUMENT...: prints the number of the job
  local task=$1 options=()
  shift
  while [ "$1" != -- ]; do options+=("$1"); shift; done
  shift
  sbatch --parsable --job-name="lcpbench-$task" --open-mode=append --kill-on-invalid-dep=yes "${options[@]}" \
    "$here/job.sh" "$task" "$lcpbench" "$folder" "$@"
}

after=()
if [ -n "$array" ]; then
  job=$(submit shard --array="$array" --cpus-per-task="$threads" --time="$minutes" ${megabytes:+--mem="${megabytes}M"} \
          --output="$folder/shard-%a.log" -- "$shards" "$@" --jobs "$threads" --costs "$pilot")
  after=(--dependency="afterok:$job")
fi
merge=$(submit merge "${after[@]}" --mem=1G --output="$folder/merge.log" --)
report=$(submit report --dependency="afterok:$merge" --mem=4G --output="$folder/report.log" --)
echo "shards: ${array:-none}, job ${job:-none}; merge: job $merge; report: job $report"
