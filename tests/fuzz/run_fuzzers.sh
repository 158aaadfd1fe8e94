#!/bin/sh
# Fuzzes every parser and keeps what was learnt in tests/fuzz/corpus/, minimised.
#
#   tests/fuzz/run_fuzzers.sh [SECONDS_PER_HARNESS] [HARNESS...]
#
# Needs clang. Stops at the first finding, which is left in build/fuzz/findings/. Harnesses run one after another, so
# that SECONDS_PER_HARNESS (default 60) is about the CPU time of each.
set -eu

root=$(cd "$(dirname "$0")/../.." && pwd)
build="$root/build/fuzz"
seconds=${1:-60}
[ $# -gt 0 ] && shift
max_files=80  # committed inputs of a harness at most, beside those that always stay
limits="-max_len=4096 -timeout=10 -rss_limit_mb=4096"

mkdir -p "$build"
cmake -S "$root" -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=RelWithDebInfo -DLCPBENCH_FUZZ=ON \
  -DCMAKE_CXX_COMPILER="${CXX:-clang++}" > "$build.configure.log" 2>&1 || { cat "$build.configure.log" >&2; exit 1; }

if [ $# -gt 0 ]; then
  harnesses=$*
  # shellcheck disable=SC2046  # one word for each target
  ninja -C "$build" $(printf '%s_fuzzer ' "$@")
else
  harnesses=$(ls "$root"/tests/fuzz/*_fuzzer.cpp | sed 's|.*/||; s|_fuzzer.cpp||')
  ninja -C "$build" fuzzers
fi

# Fuzzes from the committed and the earlier working corpus; all that is new goes to the latter.
fuzz() {
  dictionary="$root/tests/fuzz/$name.dict"
  [ -f "$dictionary" ] && dictionary="-dict=$dictionary" || dictionary=""
  log="$build/$name.log"
  echo "$name: fuzzing for $seconds s"
  # shellcheck disable=SC2086  # no word at all where there is no dictionary
  if ! "$program" -max_total_time="$seconds" $limits $dictionary -artifact_prefix="$build/findings/$name-" \
    -print_final_stats=1 "$working" "$committed" > "$log" 2>&1; then
    tail -40 "$log" >&2
    echo "$name: FINDING, input in $build/findings/" >&2
    exit 1
  fi
  grep -E 'number_of_executed_units|peak_rss_mb' "$log"
}

# Replaces the committed inputs by the smallest ones that reach the most. Those written by hand (seed-*) and past
# findings (found-*) always stay, and what they reach needs no other input.
minimise() {
  minimal="$build/minimal/$name"
  rm -rf "$minimal"
  mkdir -p "$minimal"
  for file in "$committed"/seed-* "$committed"/found-*; do
    [ -f "$file" ] && cp "$file" "$minimal/"
  done
  # shellcheck disable=SC2086
  "$program" -merge=1 $limits "$minimal" "$committed" "$working" > "$build/$name.merge.log" 2>&1
  find "$committed" -type f ! -name 'seed-*' ! -name 'found-*' -delete
  find "$minimal" -type f ! -name 'seed-*' ! -name 'found-*' -printf '%s %p\n' | sort -n | head -n "$max_files" |
    while read -r _ file; do cp "$file" "$committed/"; done
  echo "$name: $(find "$committed" -type f | wc -l) inputs committed"
}

for name in $harnesses; do
  program="$build/${name}_fuzzer"
  if [ ! -x "$program" ]; then
    echo "$name: not built here" >&2
    continue
  fi
  committed="$root/tests/fuzz/corpus/$name"
  working="$build/corpus/$name"
  mkdir -p "$committed" "$working" "$build/findings"
  fuzz
  minimise
done
