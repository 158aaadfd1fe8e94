#!/usr/bin/env bash
# `cmake --install build/release` works after ./run-study: what it installs is built by the targets that run-study names.
#   install_targets_test.sh SOURCE BUILD
set -euo pipefail
cd "$2"
targets=$(sed -n 's/^build_preset release .* -- //p' "$1/run-study")
[ -n "$targets" ] || { echo "run-study names no targets"; exit 1; }
scripts=$(find . -name cmake_install.cmake)
outputs=$(ninja -t targets all | sed 's/: [^:]*$//')
# shellcheck disable=SC2086
commands=$(ninja -t commands $targets)
checked=0
for file in $(grep -oh "\"$PWD/[^\"]*\"" $scripts | tr -d '"' | sed "s|^$PWD/||" | sort -u); do
  grep -qxF "$file" <<< "$outputs" || continue  # written by cmake itself
  checked=$((checked + 1))
  grep -qF "$file" <<< "$commands" || { echo "run-study does not build $file, which is installed"; exit 1; }
done
[ $checked -ge 2 ] || { echo "looked at $checked files only: the library and the header are installed"; exit 1; }
