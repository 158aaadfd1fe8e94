#!/bin/sh
# Keeps what results/paper shows of a store. The provenance of a store with several runs is an array.
#
#   results/paper/keep.sh LCPBENCH paper.db    overwrites provenance.json and tables/
set -eu
here=$(dirname "$0")
report=$(mktemp -d)
trap 'rm -r "$report"' EXIT
"$1" report "$2" --out "$report" >/dev/null

provenance() {
  sqlite3 "$1" 'SELECT iif(count(*) = 1, max(provenance), json_group_array(json(provenance)))
    FROM (SELECT provenance FROM runs ORDER BY started)' | sed -E -f "$here/../plain_paths.sed"
}

provenance "$2" >"$here/provenance.json"
for table in claims-paper paper-claims paper-IV.1 paper-IV.2 paper-IV.3 paper-IV.4 paper-IV.5 paper-IV.6 paper-measurements \
  readings reproduction sweeps; do
  cp "$report/tables/$table.csv" "$here/tables/$table.csv"
done
sqlite3 -csv -header "$2" <"$here/false-claims.sql" | tr -d '\r' >"$here/tables/false-claims.csv"
sha256sum "$2" "$report/tables/tolerance-map.csv" | sed 's#  .*/#  #'
