#!/usr/bin/env bash
# Makes and checks all files of a release in dist/, up to the upload: python/release.sh PYTHON311 PYTHON312
#
# Wheels, source archive, Debian packages, SHA256SUMS. Stops if the tree has changes, if versions disagree, or if a wheel does not
# run in a fresh environment. CONTRIBUTING.md has what comes before and after.
set -euo pipefail
cd "$(dirname "$0")/.."
[ $# -gt 0 ] || { sed -n '2p' "$0"; exit 2; }
. cmake/setup.sh
stop() { say "release: $*"; exit 1; }

version=$(sed -n 's/^project(lcpbench VERSION \([0-9.]*\).*/\1/p' CMakeLists.txt)
[ -z "$(git status --porcelain)" ] || stop "the tree has changes: $(git status --porcelain | head -1)"
results/age.sh || stop "README's times are older than the code: results/measure.sh"
build_preset release -DLCPBENCH_TESTS=ON
bash tests/package/version_test.sh . build/release/lcpbench "$version" || stop "versions disagree"

rm -rf dist
python/wheels.sh "$@"
for python in "$@"; do
  venv=build/wheel/fresh
  rm -rf $venv
  "$python" -m venv $venv
  $venv/bin/pip install -q numpy scipy mujoco
  $venv/bin/pip install -q --no-index --find-links dist "lcpbench==$version" || stop "$python takes no wheel of dist/"
  bash tests/package/wheel_test.sh $venv/bin || stop "the wheel does not work in $venv"
done

build/wheel/tools/bin/pip install -q build
build/wheel/tools/bin/python -m build --sdist --outdir dist
(cd build/release && cpack -B packages > package.log) || failed "cpack" build/release/package.log
cp build/release/packages/*.deb dist
for file in dist/*; do [[ $file == *[_-]$version* ]] || stop "$file is not of version $version"; done
(cd dist && sha256sum -- * > SHA256SUMS)
! grep -q OWNER CITATION.cff || say "CITATION.cff has OWNER for an account yet: put yours there first, and run this again."
say "dist/ has the release:" "$(ls dist)" "" \
  "Next: git tag -s v$version && git push origin v$version, which starts .github/workflows/wheels.yml and its upload."
