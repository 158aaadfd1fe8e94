#!/usr/bin/env bash
# Measures published times again, with the program of this checkout: results/measure.sh [readme]
#   readme   both tables of README.md: ten minutes on an idle machine. PYTHON=... names a Python with PyPI's mujoco.
# It writes the tables' files, and into results/measured.json the commit, the processor and the date.
set -euo pipefail
cd "$(dirname "$0")/.."
case "${1:-readme}" in
  readme) ;;
  *) printf "measure.sh: unknown page '%s'; known: readme\n" "$1" >&2; exit 2 ;;
esac
program=build/release/lcpbench
[ -x $program ] || { printf 'measure.sh: run ./run-study first, which builds %s\n' $program >&2; exit 2; }
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
$program run scenes --jobs 1 --budget 0 --store "$folder/scenes.db" > /dev/null
$program report "$folder/scenes.db" --out "$folder/report" > /dev/null
cp "$folder/report/tables/decision.csv" results/scenes/decision.csv
python3 results/replay/steps.py $program 3 ${PYTHON:+"$PYTHON"}
python3 - "$(git rev-parse HEAD)" << 'END'
import datetime, json, pathlib, platform, re, sys
cpu = re.search(r"model name\s*: (.*)", pathlib.Path("/proc/cpuinfo").read_text())
measured = {"commit": sys.argv[1], "processor": cpu[1] if cpu else platform.processor(), "date": datetime.date.today().isoformat()}
pathlib.Path("results/measured.json").write_text(json.dumps({"readme": measured}, indent=2) + "\n")
END
tests/docs/docs_test.py tables $program --write
results/age.sh
