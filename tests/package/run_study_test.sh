#!/usr/bin/env bash
# The last line of run-study says what the path in it is: run_study_test.sh SOURCE FOLDER
set -euo pipefail
rm -rf "$2"
mkdir -p "$2/cmake"
cp "$1/run-study" "$2"
cd "$2"

# In place of the set-up: it builds a program that does nothing, but that its `report` prints a path as the true one
# does, its `certify` ends with $CERTIFIED, and `report` and `replay` write their arguments into a file.
cat > cmake/setup.sh <<'END_OF_SETUP'
REQUIRED_PACKAGES= HELPFUL_PACKAGES= ADAPTER_PACKAGES=
say() { printf '%s\n' "$@" >&2; }
install_packages() { :; }
build_preset() {
  mkdir -p build/release
  printf '#!/bin/sh\necho "$*" >> $1.called\ncase $1 in report) echo "$4/report.html" ;; certify) exit %s ;; esac\n' "$CERTIFIED" \
    > build/release/lcpbench
  chmod +x build/release/lcpbench
}
END_OF_SETUP

# expect CERTIFIED EXIT_CODE [OPTION]
expect() {
  code=0
  CERTIFIED=$1 bash run-study ${3:+"$3"} > output 2> errors || code=$?
  [ "$code" -eq "$2" ] || { echo "certify ended with $1, run-study with $code instead of $2:"; cat output errors; exit 1; }
}

last_line="The report (open it in a browser): build/quick/report/report.html"
for certified in 0 1; do  # 1: a contradiction, which the report shows
  expect $certified $certified
  [ "$(tail -n 1 output)" = "$last_line" ] || { echo "the last line is not '$last_line':"; cat output; exit 1; }
done
expect 3 3

# The films of --replay are where the report looks for them, and no other run makes any.
[ ! -e replay.called ] || { echo "run-study replays without --replay"; exit 1; }
expect 0 0 --replay
[ "$(tail -n 1 output)" = "$last_line" ] || { echo "with --replay the last line is not '$last_line':"; cat output; exit 1; }
grep -q -- '--stepper=soft_step{substeps=5} .*--out build/replay$' replay.called || { cat replay.called; exit 1; }
tail -n 1 report.called | grep -q -- '--replay build/replay$' || { cat report.called; exit 1; }
