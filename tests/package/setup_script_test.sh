#!/usr/bin/env bash
# build_preset of cmake/setup.sh shows progress, and never ends in silence: setup_script_test.sh SOURCE FOLDER
set -euo pipefail
source=$1
rm -rf "$2"
mkdir -p "$2/build"
cd "$2"

# A script as run-study is one, with a cmake that prints what $PRINTS says and ends with $CONFIGURED or $BUILT.
cat > script <<'END'
set -euo pipefail
. "$1/cmake/setup.sh"
cmake() {
  if [ "$1" = --preset ]; then echo "configured"; return "$CONFIGURED"; fi
  for i in $(seq 1 40); do echo "[$i/40] Building $i"; done
  echo "$PRINTS"
  return "$BUILT"
}
build_preset release -DX=1 -- target
echo "the script went on"
END

# run CONFIGURED BUILT PRINTS: what the script printed, and its exit code.
run() {
  code=0
  CONFIGURED=$1 BUILT=$2 PRINTS=$3 bash script "$source" > output 2>&1 || code=$?
}

expect() {
  "$@" || { echo "Does not hold: $*. The script ended with $code and printed:"; cat output; exit 1; }
}

last_line_is() { [ "$(tail -n 1 output)" = "$1" ]; }

run 0 0 "all is well"
expect [ $code -eq 0 ]
expect last_line_is "the script went on"
expect [ "$(grep -c ' of 40 steps$' output)" -eq 10 ]
expect grep -q "all is well" build/release.build.log

run 0 1 "killed without a word that a search would find"
expect [ $code -eq 1 ]
expect grep -q "killed without a word" output
expect last_line_is "Building (release) failed. Everything it printed is in build/release.build.log"

run 0 1 "x.cpp:1:1: error: expected a declaration"
expect [ $code -eq 1 ]
expect grep -q "^41:x.cpp:1:1: error" output
expect last_line_is "Building (release) failed. Everything it printed is in build/release.build.log"

run 1 0 ""
expect [ $code -eq 1 ]
expect last_line_is "Configuring (release) failed. Everything it printed is in build/release.configure.log"
