#!/usr/bin/env bash
# study.sh PROGRAM FOLDER [TRIALS]: compares solvers of PyPI's packages with lcpbench's own on captured steps.
# Installs the packages of requirements.txt into FOLDER/venv, which needs the network: about 600 MB. Resumes.
set -euo pipefail
program=$(realpath "$1") folder=$2 trials=${3:-10}
here=$(realpath "$(dirname "$0")")
mkdir -p "$folder"
if ! [ -e "$folder/venv/installed" ]; then
  echo "Downloading from PyPI into $folder/venv (about 600 MB): $(tr '\n' ' ' < "$here/requirements.txt")" >&2
  python3 -m venv "$folder/venv" || { echo "study.sh: needs python3-venv" >&2; exit 2; }
  "$folder/venv/bin/pip" install -q -r "$here/requirements.txt"
  touch "$folder/venv/installed"
fi
python=$(realpath "$folder/venv")/bin/python
solvers=(--solver auto --solver contact_lemke)
add() { solvers+=(--solver "external{command=$python $here/$1,form=$2}"); }
add "drake_lcp.py moby" lcp
add "drake_lcp.py unrevised" lcp
add "pinocchio_cone.py admm" contact,cone=true
add "pinocchio_cone.py pgs" contact,cone=true
add "convex.py proxqp relaxed" contact
add "convex.py clarabel relaxed" contact
add "convex.py scs relaxed" contact
add drake_sap.py scene,cone=true
add "mujoco_step.py newton" scene,cone=true
add "mujoco_step.py cg" scene,cone=true
add "mujoco_step.py pgs" scene,cone=true
add newton_step.py scene,cone=true
echo '{"sequence": 1, "verb": "problem", "problem": {}}' |
  "$python" "$here/newton_step.py" > "$folder/newton.log" 2>&1  # compiles its kernels
export OPENBLAS_NUM_THREADS=1 OMP_NUM_THREADS=1
"$program" run --set 'scene/*' --trials "$trials" --jobs 1 --budget 0 --store "$folder/peers.db" "${solvers[@]}" >&2
"$program" report "$folder/peers.db" --out "$folder/report"
