#!/bin/sh
# Makes the files beside it. Studies are solved, certified, and every proof is checked by the program that shares no code.
#
#   results/certificates/make.sh LCPBENCH CHECKER STORES OUT PART...      PART: exp3 monotone copositive full_rank
set -eu
lcpbench=$1 checker=$2 stores=$3 out=$4
shift 4
study() { # NAME TRIALS CERTIFY-OPTIONS SETS...
  name=$1 trials=$2 options=$3
  shift 3
  sets=""
  for set in "$@"; do sets="$sets --set $set"; done
  # shellcheck disable=SC2086
  "$lcpbench" run $sets $solvers --trials "$trials" --store "$stores/$name.db" >/dev/null
  # shellcheck disable=SC2086
  /usr/bin/time -f '%U user s, %S system s, %e s' -o "$out/$name.time" \
    "$lcpbench" certify --store "$stores/$name.db" $options --format json >"$out/$name.json"
  sed -i -E -f "$(dirname "$0")/../plain_paths.sed" "$out/$name.json"
  python3 "$checker" "$stores/$name.db" --jobs 2 >"$out/$name.checked"
  sqlite3 -header -csv "$stores/$name.db" 'SELECT s.name AS "set", c.certificate, c.proof, COUNT(*) AS problems,
      ROUND(AVG(t.seconds), 6) AS mean_s, ROUND(MAX(t.seconds), 6) AS max_s FROM certificates c
      JOIN certificate_timings t USING (problem_id) JOIN problems p ON p.id = c.problem_id
      JOIN sets s ON s.id = p.set_id GROUP BY 1, 2, 3' | tr -d '\r' >"$out/$name.cost.csv"
}
combination='{redundancy=combination}'
for part in "$@"; do
  solvers="--solver lemke --solver primal_dual --solver active_set --solver contact_lemke"
  case $part in
    exp3) study exp3 10000 "" paper/monotone/exp3 ;;
    monotone)
      study monotone 500 "" paper/monotone/exp1 paper/monotone/exp2 "paper/monotone/exp2$combination" paper/monotone/exp4 \
        "paper/monotone/exp4$combination" paper/monotone/exp5-1e5 paper/monotone/exp5-1e8 paper/monotone/exp5-1e10 ;;
    copositive)
      solvers="--solver contact_lemke --solver lemke"
      study copositive 1000 "--every 1 --time-limit 4" paper/copositive/exp3 paper/copositive/exp4 "paper/copositive/exp4$combination" ;;
    full_rank)
      solvers="--solver contact_lemke"
      study full_rank 100 "--every 1" paper/copositive/exp1 paper/copositive/exp2 paper/copositive/exp5-1e5 \
        paper/copositive/exp5-1e8 paper/copositive/exp5-1e10 ;;
    *) echo "make.sh: unknown part '$part'" >&2; exit 2 ;;
  esac
done
