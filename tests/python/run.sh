#!/usr/bin/env bash
# run.sh SOURCE WORK PROGRAM [COMPILER]: builds the Python package in WORK and tests it with the Python of the system,
# or with $LCPBENCH_TEST_PYTHON and its own pybind11, if it has one: numpy 2 crashes with a pybind11 before 2.12. Needs no
# network. Ends with 77 where Debian packages are missing.
set -euo pipefail
source=$1 work=$2 program=$3 compiler=${4:-c++}
python=${LCPBENCH_TEST_PYTHON:-/usr/bin/python3}
if ! "$python" -c 'import numpy, scipy.sparse, sysconfig, os
assert os.path.exists(sysconfig.get_path("include") + "/Python.h")' 2>/dev/null ||
   ! { [ -d /usr/lib/cmake/pybind11 ] || [ -d /usr/share/cmake/pybind11 ]; }; then
  echo "SKIPPED: the Python package needs python3-dev, python3-numpy, python3-scipy and pybind11-dev"
  exit 77
fi
own=$("$python" -m pybind11 --cmakedir 2>/dev/null) || own=
cmake -S "$source" -B "$work/build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_UNITY_BUILD=ON \
  -DLCPBENCH_NATIVE_ONLY=ON -DLCPBENCH_PYTHON=ON -DCMAKE_CXX_COMPILER="$compiler" -DPython_EXECUTABLE="$python" \
  ${own:+-Dpybind11_DIR="$own"} > "$work.log" 2>&1 || { cat "$work.log"; exit 1; }
cmake --build "$work/build" --target lcpbench_python > "$work.log" 2>&1 || { tail -n 40 "$work.log"; exit 1; }
rm -rf "$work/site"
cmake --install "$work/build" --component python --prefix "$work/site" > /dev/null
export PYTHONPATH="$work/site" LCPBENCH_PROGRAM="$program" LCPBENCH_SOURCE="$source" PYTHONDONTWRITEBYTECODE=1
exec "$python" -m unittest discover -s "$source/tests/python" -p '*_test.py' -v
