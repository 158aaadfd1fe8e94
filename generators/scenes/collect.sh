#!/bin/sh
# Captures steps of all scenes from all engines that are installed, into FOLDER/FAMILY/ENGINE.scenes:
#   generators/scenes/collect.sh build/release/lcpbench                    the collection of this repository
#   generators/scenes/collect.sh build/release/lcpbench FOLDER 5           five times as many steps, about 2,700
#   generators/scenes/collect.sh build/release/lcpbench FOLDER 5 auto      with the solver `auto` in the loop
# Of the collection: few steps of each scene, spread over its course, and fewer of the large scenes, below 2 MB. Another
# version of an engine makes other steps; the files in the repository are those of Debian 12.
set -eu
lcpbench=$1
folder=${2:-$(dirname "$0")}
denser=${3:-1}
loop=${4:-engine}

# collect SCENE EVERY STEPS ENGINE...
collect() {
  scene=$1 every=$(($2 / denser)) steps=$3
  shift 3
  for engine in "$@"; do
    [ -x "$(dirname "$lcpbench")/lcpbench-capture-$engine" ] || { echo "$engine is not installed" >&2; continue; }
    name=$engine
    [ "$loop" = engine ] || name=$engine-$loop
    mkdir -p "$folder/$scene"
    "$lcpbench" capture "$scene" --engine "$engine" --every "$every" --steps "$steps" --loop "$loop" \
      --out "$folder/$scene/$name.scenes" || [ $? -eq 1 ]  # 1: the steps until a failure are kept
  done
}

# The same text with fewer bytes: zstd -dc FILE | zstd -19. The box piles and humanoids-22 are kept so.
all="ode bullet mujoco dart"
collect stack 40 300 $all
collect card-house 25 200 $all
collect wall 60 180 $all
collect mass-ratio-1e4 30 240 $all
collect mass-ratio-1e6 30 240 $all
collect wedge 20 180 $all
collect sphere-pile 60 300 $all
collect box-pile 60 360 $all
collect uneven-table 25 200 $all
collect gripper 25 200 $all
collect dominoes 35 280 $all
collect slope 25 200 $all
collect spinning-plate 25 200 $all
collect bouncing-balls 20 240 ode mujoco dart
collect bouncing-balls 20 260 bullet
collect quadruped-standing 50 500 mujoco dart
collect quadruped-trotting 25 600 mujoco dart
collect hand 50 800 mujoco dart
collect closed-chain 30 500 mujoco
collect humanoid-falling 35 400 mujoco
collect humanoid-lying 35 400 mujoco
collect humanoid-pushed 25 400 mujoco
collect humanoids-22 120 360 mujoco

# A few of the same scenes with a good solver in the loop.
if [ $# -eq 1 ]; then
  loop=auto
  collect stack 40 300 ode
  collect card-house 50 200 ode
  collect mass-ratio-1e4 30 240 mujoco
  collect mass-ratio-1e6 30 240 bullet
  collect wedge 20 180 $all
  collect uneven-table 50 200 dart
  collect gripper 25 200 dart
  collect dominoes 70 280 bullet
  collect quadruped-standing 100 500 mujoco
fi
