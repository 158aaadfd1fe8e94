#!/bin/sh
# Keeps what a page of docs/ quotes from a store of `lcpbench run`: the tables, cut to the columns that are needed, and
# the provenance (command, date, commit, compiler, machine).
#
#   results/keep.sh LCPBENCH STORE OUT      writes OUT.cells.csv, OUT.provenance.json and, of a sweep, OUT.sweeps.csv
set -eu
report=$(mktemp -d)
trap 'rm -r "$report"' EXIT
"$1" report "$2" --out "$report" >/dev/null
columns='"set", solver, settings, trials, claimed, solved, criterion, criterion_any, wrong, unsolvable, refused,
  missed, open, unsolvable_problems, false_claims, gave_up, "error.measure", "error.median", "error.p99", "error.max", "time.all.mean", "time.all.max"'
sqlite3 :memory: '.mode csv' '.headers on' ".import $report/tables/cells.csv cells" "SELECT $columns FROM cells" |
  tr -d '\r' >"$3.cells.csv"
sqlite3 "$2" 'SELECT provenance FROM runs' | sed -E -f "$(dirname "$0")/plain_paths.sed" >"$3.provenance.json"
if [ "$(wc -l <"$report/tables/sweeps.csv")" -gt 1 ]; then cp "$report/tables/sweeps.csv" "$3.sweeps.csv"; fi
