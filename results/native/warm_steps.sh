#!/bin/sh
# Makes warm-steps.csv: results/native/warm_steps.sh BUILD OUT [FOLDER for the captures]
# Needs the programs lcpbench, lcpbench-capture-mujoco and warm_steps in BUILD.
set -eu
build=$(cd "$1" && pwd) out=$(cd "$2" && pwd) work=${3:-$(mktemp -d)}
root=$(cd "$(dirname "$0")/../.." && pwd)
rows() { tail -n +2; }

for scene in humanoid-pushed humanoid-lying; do
  [ -e "$work/$scene.scenes" ] ||
    "$build/lcpbench" capture "$scene" --engine mujoco --every 1 --steps 120 --out "$work/$scene.scenes"
done
{
  "$build/warm_steps" 11 stack 40 50 auto
  for height in 20 10 6; do "$build/warm_steps" 11 stack $height 50 auto | rows; done
  cd "$work"
  for scene in humanoid-pushed humanoid-lying; do "$build/warm_steps" 11 $scene.scenes auto | rows; done
  cd "$root/generators/scenes"
  for scene in wall/ode card-house/ode; do "$build/warm_steps" 11 $scene.scenes auto | rows; done
} > "$out/warm-steps.csv"
