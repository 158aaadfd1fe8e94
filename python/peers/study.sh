#!/usr/bin/env bash
# study.sh PROGRAM FOLDER [TRIALS]: compares solvers of PyPI's packages with lcpbench's own on captured steps, and steps
# scenes on by the engines Rapier and Jolt.
# Installs the packages of requirements.txt, and Jolt from npm where node is there, into FOLDER/venv, which needs the
# network: about 600 MB. What cannot be had is named and left out. Resumes.
set -euo pipefail
program=$(realpath "$1") folder=$2 trials=${3:-10}
here=$(realpath --relative-to=. "$(dirname "$0")")  # names in store and report hold no folder of this machine
mkdir -p "$folder"
python=$(realpath --relative-to=. "$folder")/venv/bin/python
if ! [ -e "$folder/venv/installed" ]; then
  echo "Downloading from PyPI into $folder/venv (about 600 MB): $(tr '\n' ' ' < "$here/requirements.txt")" >&2
  python3 -m venv "$folder/venv" || { echo "study.sh: needs python3-venv" >&2; exit 2; }
  "$python" -m pip install -q -r "$here/requirements.txt" >&2 || while read -r package; do
    "$python" -m pip install -q "$package" >&2 || echo "pip cannot install $package" >&2
  done < "$here/requirements.txt"
  touch "$folder/venv/installed"
fi
jolt=$folder/venv/node_modules/jolt-physics
if ! [ -e "$jolt" ] && command -v npm > /dev/null; then
  npm install --silent --prefix "$folder/venv" jolt-physics@1.1 >&2 || echo "npm cannot install jolt-physics" >&2
fi
solvers=(--solver auto --solver contact_lemke)
has() { "$python" -c "import importlib.util as u, sys; sys.exit(u.find_spec('$1') is None)"; }
add() {  # MODULE "SCRIPT ARGUMENTS" FORM
  if has "$1"; then
    solvers+=(--solver "external{command=$python $here/$2,form=$3}")
  else
    echo "Left out, because $1 is not there: $2" >&2
  fi
}
add pydrake "drake_lcp.py moby" lcp
add pydrake "drake_lcp.py unrevised" lcp
add pinocchio "pinocchio_cone.py admm" contact,cone=true
add pinocchio "pinocchio_cone.py pgs" contact,cone=true
add proxsuite "convex.py proxqp relaxed" contact
add clarabel "convex.py clarabel relaxed" contact
add scs "convex.py scs relaxed" contact
add pydrake drake_sap.py scene,cone=true
add mujoco "mujoco_step.py newton" scene,cone=true
add mujoco "mujoco_step.py cg" scene,cone=true
add mujoco "mujoco_step.py pgs" scene,cone=true
echo "Newton compiles its kernels, the first time for some minutes ..." >&2
if echo '{"sequence": 1, "verb": "problem", "problem": {}}' | "$python" "$here/newton_step.py" > "$folder/newton.log" 2>&1; then
  add newton newton_step.py scene,cone=true
else
  echo "Left out, because it does not start ($folder/newton.log): newton_step.py" >&2
fi
export OPENBLAS_NUM_THREADS=1 OMP_NUM_THREADS=1
"$program" run --set 'scene/*' --trials "$trials" --jobs 1 --budget 0 --store "$folder/peers.db" "${solvers[@]}" >&2
step_on() {  # NAME COMMAND
  echo "Stepping ten cubes, a card house, a gripper and a pile on by $1 ..." >&2
  "$program" replay cubes-10 card-house gripper sphere-pile --engine "external{command=$2}" --engine-solver \
    --stepper exact --out "$folder/$1" >&2
}
if has rapier3d; then step_on rapier "$python $here/rapier_engine.py"; fi
if [ -e "$jolt" ]; then step_on jolt "node --disable-wasm-trap-handler $here/jolt.mjs $folder/venv/node_modules"; fi
"$program" report "$folder/peers.db" --out "$folder/report"
