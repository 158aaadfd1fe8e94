#!/usr/bin/env bash
# Says how many commits changed the code that README's times are of since these were measured. Exit code 1: some did.
# results/age.sh [COMMIT]: as if they were of that commit.
set -euo pipefail
cd "$(dirname "$0")/.."
commit=${1:-$(sed -n 's/.*"readme": {"commit": "\([0-9a-f]*\)".*/\1/p' results/measured.json)}
changed=$(git rev-list --count "$commit..HEAD" -- core native adapters generators study/run) || exit 2
printf "README's times are of %.8s; %d commits changed the code that they time since.\n" "$commit" "$changed"
[ "$changed" -eq 0 ]
