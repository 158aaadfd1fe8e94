#!/usr/bin/env bash
# Runs a plan as a Slurm array, then merges the shards' stores, then writes the report:
#   submit.sh SHARDS FOLDER PILOT PLAN [OPTION...]
# FOLDER is for the stores, on a file system that all nodes see. PILOT is the store of a small run of the plan; time
# limit and memory come from it. OPTION... are options of `lcpbench run`. The same command again runs what is missing.
# THREADS is the number of threads of a shard (1).
set -euo pipefail
shards=$1 folder=$(realpath -m "$2") pilot=$(realpath "$3")
shift 3
lcpbench=$(command -v lcpbench)
mkdir -p "$folder"
run=("$lcpbench" run "$@" --jobs "${THREADS:-1}" --costs "$pilot")

list=$("${run[@]}" --list-shards "$shards" --store "$folder/shard-{}.db" --format json)
of_list() { sed -n "s/^  \"$1\": \"\{0,1\}\([^\"]*\)\"\{0,1\},$/\1/p" <<< "$list"; }
array=$(of_list array)

# submit TASK COMMAND OPTION...: prints the job's number. `exec`: Slurm's SIGTERM reaches lcpbench, which saves.
submit() {
  sbatch --parsable --job-name="lcpbench-$1" --open-mode=append --kill-on-invalid-dep=yes --wrap "exec $2" "${@:3}"
}

after=()
if [ -n "$array" ]; then
  task='"$SLURM_ARRAY_TASK_ID"'
  job=$(submit shard "${run[*]@Q} --shard $task/$shards --store ${folder@Q}/shard-$task.db" --array="$array" \
          --cpus-per-task="${THREADS:-1}" --time="$(of_list minutes)" --mem="$(of_list megabytes)M" \
          --output="$folder/shard-%a.log")
  after=(--dependency="afterok:$job")
fi
merge=$(submit merge "${lcpbench@Q} merge ${folder@Q}/merged.db ${folder@Q}/shard-*.db" "${after[@]}" --mem=1G \
          --output="$folder/merge.log")
report=$(submit report "${lcpbench@Q} report ${folder@Q}/merged.db --out ${folder@Q}/report" \
           --dependency="afterok:$merge" --mem=4G --output="$folder/report.log")
echo "shards: ${array:-none}, job ${job:-none}; merge: job $merge; report: job $report"
