#!/usr/bin/env bash
# Tables of times that are older than the code they time are found: age_test.sh AGE, in a repository of its own.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
mkdir -p "$folder/results" "$folder/native"
cp "$1" "$folder/results/age.sh"
cd "$folder"
export GIT_AUTHOR_NAME=t GIT_AUTHOR_EMAIL=t@t GIT_COMMITTER_NAME=t GIT_COMMITTER_EMAIL=t@t
git init -q .
commit() { git add -A && git commit -qm "$1"; }
echo 1 > native/a.cpp && commit code
printf '{\n  "readme": {"commit": "%s", "date": "today"},\n  "replay": {"commit": "0"}\n}\n' "$(git rev-parse HEAD)" > results/measured.json && commit times
results/age.sh | grep -q ' 0 commits changed' || { echo "fresh times are called old"; exit 1; }
echo 2 > native/a.cpp && commit 'other code'
if results/age.sh > said; then echo "old times are not refused"; exit 1; fi
grep -q ' 1 commits changed' said || { cat said; exit 1; }
