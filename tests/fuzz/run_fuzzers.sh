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
max_files=100   # committed inputs of a harness at most
max_bytes=4096  # size of an input at most

cmake -S "$root" -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=RelWithDebInfo -DLCPBENCH_FUZZ=ON \
  -DCMAKE_CXX_COMPILER="${CXX:-clang++}" > "$build.configure.log" 2>&1 || { cat "$build.configure.log" >&2; exit 1; }
ninja -C "$build" fuzzers

harnesses=${*:-$(ls "$root"/tests/fuzz/*_fuzzer.cpp | sed 's|.*/||; s|_fuzzer.cpp||')}
for name in $harnesses; do
  program="$build/${name}_fuzzer"
  if [ ! -x "$program" ]; then
    echo "$name: not built here" >&2
    continue
  fi
  committed="$root/tests/fuzz/corpus/$name"
  working="$build/corpus/$name"
  mkdir -p "$committed" "$working" "$build/findings"
  dictionary="$root/tests/fuzz/$name.dict"
  [ -f "$dictionary" ] && dictionary="-dict=$dictionary" || dictionary=""
  log="$build/$name.log"
  echo "$name: fuzzing for $seconds s"
  # shellcheck disable=SC2086  # no word at all where there is no dictionary
  if ! "$program" -max_total_time="$seconds" -max_len="$max_bytes" -timeout=10 -rss_limit_mb=4096 $dictionary \
    -artifact_prefix="$build/findings/$name-" -print_final_stats=1 "$working" "$committed" > "$log" 2>&1; then
    tail -40 "$log" >&2
    echo "$name: FINDING, input in $build/findings/" >&2
    exit 1
  fi
  grep -E 'number_of_executed_units|peak_rss_mb' "$log"

  # The smallest inputs that together reach everything the fuzzer has reached.
  minimal="$build/minimal/$name"
  rm -rf "$minimal"
  mkdir -p "$minimal"
  "$program" -merge=1 -max_len="$max_bytes" -timeout=10 -rss_limit_mb=4096 "$minimal" "$committed" "$working" \
    > "$build/$name.merge.log" 2>&1
  # libFuzzer merges small inputs first, so the smallest files reach the most per byte.
  for file in $(ls -Sr "$minimal" | head -n "$max_files"); do
    cp "$minimal/$file" "$committed/$file"
  done
  for file in "$committed"/*; do
    case "$(basename "$file")" in
      seed-* | found-*) continue ;;  # written by hand, or a past finding: always kept
    esac
    [ -f "$minimal/$(basename "$file")" ] && ls -Sr "$minimal" | head -n "$max_files" | grep -qx "$(basename "$file")" ||
      rm "$file"
  done
  echo "$name: $(ls "$committed" | wc -l) inputs committed"
done
