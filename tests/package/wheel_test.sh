#!/usr/bin/env bash
# wheel_test.sh BIN: the wheel that is installed, with MuJoCo, in the environment with that bin folder works, without a
# compiler and without another lcpbench. python/release.sh and cibuildwheel call it.
set -euo pipefail
root=$(cd "$(dirname "$0")/../.." && pwd) bin=$(cd "$1" && pwd) work=$(mktemp -d)
version=$(sed -n "s/^project(lcpbench VERSION \([0-9.]*\).*/\1/p" "$root/CMakeLists.txt")
trap 'rm -rf "$work"' EXIT
unset LCPBENCH_PROGRAM PYTHONPATH
cd "$work"
lcpbench() { "$bin/lcpbench" "$@"; }
[ "$(lcpbench --version)" = "lcpbench $version" ]
[ "$("$bin/python" -m lcpbench --version)" = "lcpbench $version" ]
lcpbench run smoke --store smoke.db > log 2>&1
lcpbench report smoke.db --out report > log
lcpbench capture slope --engine ode --every 20 --steps 60 --out slope.scenes > log
lcpbench view slope.scenes#20 --out view.html > log
lcpbench replay stack --solver auto --stepper soft_step --steps 20 --out replay > log
[ -s report/index.html ] && [ -s view.html ] && [ "$(wc -l < replay/summary.csv)" = 4 ]
lcpbench solve slope.scenes#20 --solver "external{command=$bin/python $root/examples/external_solver.py}" --solver auto --format json > answers.json
lcpbench certify slope.scenes#20 --format json > proof.json
"$bin/python" - "$version" <<'P'
import json, sys
import lcpbench
assert lcpbench.__version__ == sys.argv[1]
answer = lcpbench.solve(lcpbench.load("slope.scenes#20"))
assert answer.verdict == "solved", answer
assert [each["claim"] for each in json.load(open("answers.json"))] == ["solved", "solved"]
libraries = [each for each in lcpbench.available_solvers() if each.library == "Siconos numerics"]
assert libraries and all("./run-study" in each.unavailable for each in libraries), libraries
P
# README's Python as printed, after a robot: a ball on a plane.
{ cat <<'P'; sed -n '/^```py$/,/^```$/p' "$root/README.md" | sed '/^```/d'; } > robot.py
import mujoco
model = mujoco.MjModel.from_xml_string("""<mujoco><worldbody><geom type="plane" size="1 1 1"/>
  <body pos="0 0 .049"><freejoint/><geom size=".05"/></body></worldbody></mujoco>""")
data = mujoco.MjData(model)
P
"$bin/python" robot.py > log
grep -q '^solved \[\[' log
echo "the wheel of $version works"
