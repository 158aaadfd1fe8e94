#!/bin/sh
# Keeps what results/paper shows of a store. The provenance of a store with several runs is an array.
#
#   results/paper/keep.sh LCPBENCH paper.db             of the run: overwrites provenance.json, rules.csv and tables/
#   results/paper/keep.sh LCPBENCH rules.db ablation    of the ablation: overwrites ablation.csv and ablation.provenance.json
set -eu
here=$(dirname "$0")
report=$(mktemp -d)
trap 'rm -r "$report"' EXIT
"$1" report "$2" --out "$report" >/dev/null

# Sweeps of lemke and primal_dual: worst / average / best share of all trials, by the criterion and by our verdict.
sweeps() {
  sqlite3 :memory: '.mode csv' '.headers on' ".import $report/tables/cells.csv cells" \
    "SELECT \"set\", solver, sweep, count(*) AS cells, min(trials + 0) AS trials, $(range criterion), $(range criterion_any),
       $(range solved)
     FROM cells WHERE solver IN ('lemke', 'primal_dual') AND sweep LIKE '$1' GROUP BY 1, 2, 3" | tr -d '\r'
}
range() {
  echo "min(1.0 * $1 / trials) AS \"$1.worst\", avg(1.0 * $1 / trials) AS \"$1.average\", max(1.0 * $1 / trials) AS \"$1.best\""
}
provenance() {
  sqlite3 "$1" 'SELECT iif(count(*) = 1, max(provenance), json_group_array(json(provenance)))
    FROM (SELECT provenance FROM runs ORDER BY started)' | sed -E -f "$here/../plain_paths.sed"
}

if [ "${3:-}" = ablation ]; then
  sweeps '%' >"$here/ablation.csv"
  provenance "$2" >"$here/ablation.provenance.json"
  exit
fi
sweeps '%rules=2012%' >"$here/rules.csv"
provenance "$2" >"$here/provenance.json"
for table in claims-paper paper-claims paper-IV.1 paper-IV.2 paper-IV.3 paper-IV.4 paper-IV.5 paper-IV.6 paper-measurements \
  readings reproduction sweeps; do
  cp "$report/tables/$table.csv" "$here/tables/$table.csv"
done
sqlite3 -csv -header "$2" <"$here/false-claims.sql" | tr -d '\r' >"$here/tables/false-claims.csv"
sha256sum "$2" "$report/tables/tolerance-map.csv" | sed 's#  .*/#  #'
