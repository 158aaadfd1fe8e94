#!/usr/bin/env bash
# debian_test.sh SOURCE BUILD WORK: makes the Debian packages of a build, unpacks them, and tries the program, its
# manual and its completions from there.
set -euo pipefail
source=$1 build=$2 work=$3
command -v dpkg-shlibdeps > /dev/null || { echo "SKIPPED: needs dpkg-dev"; exit 77; }
fail() { echo "$*"; exit 1; }
rm -rf "$work"
mkdir -p "$work/root"
(cd "$build" && cpack -B "$work" > "$work/log" 2>&1) || { cat "$work/log"; exit 1; }
for package in "$work"/lcpbench_*.deb "$work"/liblcpbench-dev_*.deb; do
  dpkg-deb -c "$package" | awk '!/^d/ { print $6 }' >> "$work/files"
  dpkg-deb -x "$package" "$work/root"
done
[ -z "$(sort "$work/files" | uniq -d)" ] || fail "both packages hold $(sort "$work/files" | uniq -d)"
dpkg-deb -f "$work"/lcpbench_*.deb Depends | grep -q 'libsqlite3-0.*zlib1g' || fail "no package is named as needed"
dpkg-deb -f "$work"/liblcpbench-dev_*.deb Depends | grep -q libeigen3-dev || fail "Eigen is not named as needed"

export PATH="$work/root/usr/bin:$PATH"
cd "$work"
workers=$(ls root/usr/libexec/lcpbench | grep -c worker)
[ "$workers" -ge 1 ] || fail "no worker is installed"
lcpbench solve "$source/examples/box_on_slope.json" --solver "external{command=$source/examples/external_solver.py}" \
  --format json > answer.json || fail "the installed program does not find its worker"

commands=$(lcpbench --help | sed -nE '/^Subcommands:/,/^$/s/^  ([a-z]+) .*/\1/p')
page=root/usr/share/man/man1/lcpbench.1
for command in $commands; do
  grep -qx ".SH \"LCPBENCH ${command^^}\"" $page || fail "the manual has no $command"
done
grep -qF 'm/s: solve each island' $page || fail "the manual has no text of an option"
. root/usr/share/bash-completion/completions/lcpbench
completes() {  # WORDS EXPECTED
  read -ra COMP_WORDS <<< "$1"
  [ "${1: -1}" != " " ] || COMP_WORDS+=("")
  COMP_CWORD=$((${#COMP_WORDS[@]} - 1))
  COMPREPLY=()
  _lcpbench
  [ "${COMPREPLY[*]}" = "$2" ] || fail "'$1' is completed by '${COMPREPLY[*]}', expected '$2'"
}
completes "lcpbench " "$(echo $commands)"
completes "lcpbench sol" "solvers solve"
completes "lcpbench solve --max" "--max-velocity-error"
completes "lcpbench solve --format " "text json"
completes "lcpbench solve box" ""
if command -v zsh > /dev/null; then zsh -n root/usr/share/zsh/vendor-completions/_lcpbench; fi
