#!/usr/bin/env bash
# A job of submit.sh: one shard of the array, the merge of all, or the report. `exec`: Slurm's signals reach lcpbench,
# which saves and ends on SIGTERM.
set -euo pipefail
task=$1 lcpbench=$2 folder=$3
shift 3
case $task in
  shard)
    shards=$1 number=$SLURM_ARRAY_TASK_ID
    shift
    exec "$lcpbench" run "$@" --shard "$number/$shards" --store "$folder/shard-$number.db" ;;
  merge) exec "$lcpbench" merge "$folder/merged.db" "$folder"/shard-*.db ;;
  report) exec "$lcpbench" report "$folder/merged.db" --out "$folder/report" ;;
esac
