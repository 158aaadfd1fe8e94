#!/usr/bin/env bash
# Measures published tables again, with the program of this checkout: results/measure.sh [PAGE...], on an idle machine
#   readme   both tables of README.md: ten minutes
#   quick    results/quick, and README's picture: ten minutes
#   replay   the generated tables of results/replay: ten minutes
# It writes the tables and their files, and into results/measured.json commit, processor and date of each page. PYTHON is
# a Python with PyPI's mujoco and rapier3d, MODULES a folder with npm's jolt-physics; by default those of ./run-tests.
set -euo pipefail
cd "$(dirname "$0")/.."
[ $# -gt 0 ] || set -- readme
for page in "$@"; do
  case "$page" in
    readme | quick | replay) ;;
    *) printf "measure.sh: unknown page '%s'; known: readme, quick, replay\n" "$page" >&2; exit 2 ;;
  esac
done
program=build/release/lcpbench
[ -x $program ] || { printf 'measure.sh: run ./run-study first, which builds %s\n' $program >&2; exit 2; }
python=${PYTHON:-build/nanobind/bin/python} modules=${MODULES:-build/nanobind/node_modules}
commit=$(git rev-parse HEAD) folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

readme() {
  $program run scenes --jobs 1 --budget 0 --store "$folder/scenes.db" > /dev/null
  $program report "$folder/scenes.db" --out "$folder/report" > /dev/null
  cp "$folder/report/tables/decision.csv" results/scenes/decision.csv
  python3 results/replay/steps.py $program 3 "$python"
}
quick() {
  $program run quick --jobs 1 --store "$folder/quick.db" > /dev/null
  $program certify --store "$folder/quick.db" --set 'paper/*' --set 'rigid/*' --format json > /dev/null
  $program report "$folder/quick.db" --out "$folder/quick" > /dev/null
  cp "$folder/quick/tables/decision.csv" results/quick/decision.csv
  $program run quick --trials 10 --store "$folder/ten.db" > /dev/null
  $program report "$folder/ten.db" --out "$folder/ten" > /dev/null
  python3 results/quick/pictures.py "$folder/ten/report.html" results/quick/scenes
}
replay() {
  local steppers=(convex pgs 'pgs{iterations=1,substeps=10}' sequential_impulses soft_step xpbd admm apgd)
  local scenes=(cubes-10 cubes-20 pyramid-55 arch card-house wall mass-ratio-1e4 mass-ratio-1e6 heavy-ball uneven-table
    gripper slope slopes wedge dominoes box-pile sphere-pile)
  local robots=(quadruped-trotting quadruped-standing hand chain-1e4)
  step() { $program replay "${@:2}" --engine-solver --out "$folder/$1" > /dev/null; }  # one after the other
  step ode "${scenes[@]}" --solver auto --solver 'cone_ipm{cone=true}' "${steppers[@]/#/--stepper=}" --steps 300
  step bullet "${scenes[@]}" --engine bullet --solver auto --steps 300
  step rapier "${scenes[@]}" --engine "external{command=$python python/peers/rapier_engine.py}" --solver auto --steps 300
  step jolt "${scenes[@]}" --engine "external{command=node --disable-wasm-trap-handler python/peers/jolt.mjs $modules}" \
    --solver auto --steps 300
  step robots "${robots[@]}" --stepper exact --stepper 'exact{solver=cone_ipm{cone=true}}' --stepper convex --parting --steps 400
  head -n 1 "$folder/ode/summary.csv" > results/replay/summary.csv
  for each in ode bullet rapier jolt robots; do tail -n +2 "$folder/$each/summary.csv" >> results/replay/summary.csv; done
}

for page in "$@"; do
  $page
  python3 - "$page" "$commit" << 'END'
import datetime, json, pathlib, platform, re, sys
page, commit = sys.argv[1:]
cpu = re.search(r"model name\s*: (.*)", pathlib.Path("/proc/cpuinfo").read_text())
file = pathlib.Path("results/measured.json")
measured = json.loads(file.read_text())
measured[page] = {"commit": commit, "processor": cpu[1] if cpu else platform.processor(),
                  "date": datetime.date.today().isoformat()}
lines = ",\n".join(f'  "{page}": {json.dumps(measured[page])}' for page in sorted(measured))
file.write_text(f"{{\n{lines}\n}}\n")
END
done
tests/docs/docs_test.py tables $program --write
results/age.sh
