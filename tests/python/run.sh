#!/usr/bin/env bash
# run.sh SOURCE WORK PROGRAM [COMPILER]: builds the Python package in WORK and tests it with $LCPBENCH_TEST_PYTHON, or
# with Debian's Python and the nanobind that ./run-tests brings from PyPI. Needs no network. Ends with 77 where
# something is missing.
set -euo pipefail
source=$1 work=$2 program=$3 compiler=${4:-c++}
python=${LCPBENCH_TEST_PYTHON:-$source/build/nanobind/bin/python}
if ! why=$("$python" -c 'import nanobind, numpy, scipy.sparse, sysconfig
open(sysconfig.get_path("include") + "/Python.h")' 2>&1); then
  echo "SKIPPED: ${why##*$'\n'}. ./run-tests brings what the Python package needs: python3-dev, python3-numpy," \
    "python3-scipy, python3-venv, and nanobind from PyPI"
  exit 77
fi
cmake -S "$source" -B "$work/build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_UNITY_BUILD=ON \
  -DLCPBENCH_NATIVE_ONLY=ON -DLCPBENCH_PYTHON=ON -DCMAKE_CXX_COMPILER="$compiler" -DPython_EXECUTABLE="$python" \
  > "$work.log" 2>&1 || { cat "$work.log"; exit 1; }
cmake --build "$work/build" --target lcpbench_python lcpbench_c > "$work.log" 2>&1 || { tail -n 40 "$work.log"; exit 1; }
rm -rf "$work/site"
cmake --install "$work/build" --component python --prefix "$work/site" > /dev/null
export PYTHONPATH="$work/site" LCPBENCH_PROGRAM="$program" LCPBENCH_SOURCE="$source" \
  LCPBENCH_C="$work/build/liblcpbench_c.so" PYTHONDONTWRITEBYTECODE=1
"$python" -m unittest discover -s "$source/tests/python" -p '*_test.py' -v 2>&1 | tee "$work.tests.log"
