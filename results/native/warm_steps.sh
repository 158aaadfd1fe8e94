#!/bin/sh
# Makes warm-steps.csv: results/native/warm_steps.sh BUILD OUT [FOLDER for the captures]
# Needs the programs lcpbench, lcpbench-capture-mujoco and warm_steps in BUILD.
set -eu
build=$(cd "$1" && pwd) out=$(cd "$2" && pwd) work=${3:-$(mktemp -d)}
root=$(cd "$(dirname "$0")/../.." && pwd)
rows() { tail -n +2; }

# capture NAME SCENE STEPS LOOP: every step from MuJoCo
capture() {
  [ -e "$work/$1.scenes" ] ||
    "$build/lcpbench" capture "$2" --engine mujoco --every 1 --steps "$3" --loop "$4" --out "$work/$1.scenes"
}
# Until step 60 the humanoid that is pushed later stands; with `auto` in the loop its feet stay on the floor.
capture humanoid-standing humanoid-pushed 60 auto
capture humanoid-lying humanoid-lying 120 auto
capture humanoid-pushed-mujoco humanoid-pushed 120 engine
capture humanoid-lying-mujoco humanoid-lying 120 engine
capture quadruped-standing-mujoco quadruped-standing 200 engine
{
  "$build/warm_steps" 11 stack 40 50 auto
  for height in 20 10 6; do "$build/warm_steps" 11 stack $height 50 auto | rows; done
  cd "$work"
  for scene in humanoid-standing humanoid-lying humanoid-pushed-mujoco humanoid-lying-mujoco \
    quadruped-standing-mujoco; do
    "$build/warm_steps" 11 $scene.scenes auto | rows
  done
  cd "$root/generators/scenes"
  for scene in wall/ode card-house/ode; do "$build/warm_steps" 11 $scene.scenes auto | rows; done
} > "$out/warm-steps.csv"
