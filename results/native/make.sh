#!/bin/sh
# Makes the files beside it that the pages of docs/ on native solvers quote, from a build folder.
#
#   results/native/make.sh BUILD WORK OUT PART...     WORK: a folder for stores, resumed where it has some
#
# PART: ratios shares extra100. Times are thread CPU times; for figures as quiet as those
# here give the commands a processor of their own.
set -eu
build=$1 work=$2 out=$3
shift 3
lcpbench=$build/lcpbench
here=$(dirname "$0")
ratio_seed=20261123
share_seed=20261130
combination='{redundancy=combination}'
mkdir -p "$work"

each_full_rank_set() { # KIND: the full-rank sets of the paper, both readings of redundancy
  echo "paper/$1/exp1"
  for experiment in exp2 exp5-1e5 exp5-1e8 exp5-1e10; do
    echo "paper/$1/$experiment"
    echo "paper/$1/$experiment$combination"
  done
}

file_name() { # SET -> monotone-exp2-combination
  echo "$1" | sed -e 's,^paper/,,' -e 's,/,-,' -e "s,$combination,-combination,"
}

bench() { # FILE ARGUMENTS...
  file=$work/ratios-$1.json
  shift
  "$lcpbench" bench "$@" --seed $ratio_seed --format json >"$file.part"
  sed -E -f "$here/../plain_paths.sed" "$file.part" >"$file"
  rm "$file.part"
}

large_problems() { # the first 1,000 of paper/copositive/exp1 with n > 340, as files
  if [ -d "$work/large" ]; then return; fi
  "$lcpbench" generate paper/copositive/exp1 --seed $ratio_seed --count 10500 --out "$work/all" >/dev/null
  mkdir "$work/large.part"
  python3 - "$work" <<'EOF'
import json, pathlib, sys
work, kept = pathlib.Path(sys.argv[1]), 0
for path in sorted((work / "all").glob("*.json")):
    problem = json.loads(path.read_text())
    contacts = len(problem["mu"])
    if 2 * contacts + len(problem["D"][0]) > 340 and kept < 1000:
        path.rename(work / "large.part" / path.name)
        kept += 1
if kept < 1000:
    sys.exit(f"only {kept} problems with n > 340")
EOF
  rm -r "$work/all"
  mv "$work/large.part" "$work/large"
}

ratios() {
  for set in $(each_full_rank_set monotone); do
    name=$(file_name "$set")
    bench "dense-$name" --solver active_set --set "$set" --problems 1000
    bench "kernel-$name" --reference 'lemke{engine=kernel,test=none}' --solver active_set --set "$set" --problems 1000
    for diagonal in 1e-8 1e-10 1e-12 1e-13; do
      bench "bullet_dantzig-$diagonal-$name" --reference "bullet_dantzig{diagonal=$diagonal}" --solver active_set --set "$set" \
        --problems 1000
    done
    bench "siconos_lemke-$name" --reference siconos_lemke --solver active_set --set "$set" --problems 1000
  done
  for set in $(each_full_rank_set copositive); do
    name=$(file_name "$set")
    bench "dense-$name" --solver contact_lemke --set "$set" --problems 1000
    bench "kernel-$name" --reference 'lemke{engine=kernel,test=none}' --solver contact_lemke --set "$set" --problems 1000
  done
  bench kernel-copositive-extra100 --reference 'lemke{engine=kernel,test=none}' --solver contact_lemke --set paper/copositive/extra100 \
    --problems 30
  large_problems
  bench dense-copositive-n-over-340 --solver contact_lemke --set "file:$work/large" --problems 1000
  python3 "$here/collect_ratios.py" "$work" "$out"
}

study() { # NAME ARGUMENTS...: runs a study, resumed where it stopped, and keeps its tables
  name=$1
  shift
  "$lcpbench" run "$@" --seed $share_seed --store "$work/$name.db" >/dev/null
  "$here/../keep.sh" "$lcpbench" "$work/$name.db" "$out/$name"
  "$lcpbench" report "$work/$name.db" --out "$work/$name.report" >/dev/null
  sqlite3 :memory: '.mode csv' '.headers on' ".import $work/$name.report/tables/cells.csv cells" \
    'SELECT "set", solver, settings, trials, claimed, solved, solved_1e6, solved_1e9, false_claims, rate_low FROM cells' |
    tr -d '\r' >"$out/$name.shares.csv"
}

study_of() { # NAME SETS ARGUMENTS...
  name=$1 sets=
  for set in $2; do sets="$sets --set $set"; done
  shift 2
  # shellcheck disable=SC2086
  study "$name" $sets "$@"
}

shares() {
  study_of auto-monotone "$(each_full_rank_set monotone)" --solver auto --trials 10000
  study_of auto-copositive "$(each_full_rank_set copositive)" --solver auto --trials 2000
  for kind in monotone copositive; do
    study_of contact_lemke-$kind "$(each_full_rank_set $kind)" --solver contact_lemke \
      --solver 'contact_lemke{precision=double}' --trials 2000
  done
}

extra100() {
  study auto-extra100 "$here/auto-extra100.plan.json" --jobs 1
}

for part in "$@"; do
  case $part in
    ratios | shares | extra100) $part ;;
    *) echo "make.sh: unknown part '$part'" >&2; exit 2 ;;
  esac
done
