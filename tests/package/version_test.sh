#!/usr/bin/env bash
# version_test.sh ROOT PROGRAM VERSION: one version, that of CMakeLists.txt, is told by the program, by the citation, by
# the recipe for conda and by the newest entry of the changelog.
set -euo pipefail
root=$1 program=$2 version=$3
told=$("$program" --version)
cited=$(sed -n 's/^version: //p' "$root/CITATION.cff")
logged=$(sed -n 's/^## \[\([0-9.]*\)\].*/\1/p' "$root/CHANGELOG.md" | head -1)
recipe=$(sed -n 's/^  version: "\(.*\)"$/\1/p' "$root/python/conda/recipe.yaml")
for other in "${told##* }" "$cited" "$recipe" "$logged"; do
  if [ "$other" != "$version" ]; then
    echo "CMakeLists.txt: $version; lcpbench --version: $told; CITATION.cff: $cited; recipe.yaml: $recipe; CHANGELOG.md: $logged"
    exit 1
  fi
done
