#!/usr/bin/env python3
"""cost.py LCPBENCH FOLDER PASSES SCENE...: a second of each scene with each stepper over its own parameter, and with the engines' own steps.

Writes FOLDER/cost.csv, and in FOLDER/PASS/ENGINE/index.html the films and the curves of error against processor time. All scenes are stepped on PASSES
times, one pass after the other; of the processor times of a row the least is kept. Scenes with joints are stepped by MuJoCo alone, and their parameter
is the length of the step.
"""
import csv
import pathlib
import subprocess
import sys

LCPBENCH, FOLDER, PASSES = sys.argv[1], pathlib.Path(sys.argv[2]), int(sys.argv[3])
ROBOTS = [scene for scene in sys.argv[4:] if scene in ("quadruped-trotting", "chain-1e4")]
BODIES = [scene for scene in sys.argv[4:] if scene not in ROBOTS]
LARGE = "sphere-pile-500"  # once, without the round cone, its relaxation, MuJoCo and DART, which take longer than all the other scenes
SOLVES = ["exact", "exact{solver=cone_ipm{cone=true}}", "convex"]
SWEEPS = [text for n in (5, 10, 20, 50, 100)
          for text in (f"sequential_impulses{{iterations={n}}}", f"pgs{{iterations={n}}}", f"pgs{{iterations=1,substeps={n}}}")]
OTHERS = ([f"soft_step{{substeps={n}}}" for n in (2, 4, 8, 16, 32, 64)] + [f"xpbd{{substeps={n}}}" for n in (5, 10, 20, 40)] +
          [f"{name}{{iterations={n}}}" for n in (20, 50, 100, 200) for name in ("admm", "apgd")])
FREE = [*SOLVES, "sequential_impulses", *SWEEPS, *OTHERS]
JOINTED = [*SOLVES, *(f"exact{{solver=psor{{max_iterations={n}}}}}" for n in (5, 10, 20, 50, 100))]


def replay(folder, scenes, steppers, steps, engine=()):
    if not scenes:
        return []
    options = [word for stepper in steppers for word in ("--stepper", stepper)]
    subprocess.run([LCPBENCH, "replay", *scenes, *options, *engine, "--engine-solver", "--steps", str(steps), "--out", folder], check=True,
                   stdout=subprocess.DEVNULL)
    with open(folder / "summary.csv", newline="") as file:
        return list(csv.DictReader(file))


rows = {}
for number in range(PASSES):
    made = FOLDER / str(number + 1)
    small = [scene for scene in BODIES if scene != LARGE]
    large = [scene for scene in BODIES if scene == LARGE and number == 0]
    passed = replay(made / "ode", small, FREE, 200)
    passed += replay(made / "ode-large", large, [stepper for stepper in FREE if stepper not in SOLVES[1:]], 200)
    for engine, scenes in (("bullet", small + large), ("mujoco", small), ("dart", small)):
        passed += [row for row in replay(made / engine, scenes, [], 200, ("--engine", engine)) if row["stepper"] == "engine"]
    for divide in (1, 2, 4):
        divided = [f"{scene}{{divide={divide}}}" for scene in ROBOTS]
        passed += replay(made / f"robots-{divide}", divided, JOINTED, 400 * divide)
    for row in passed:
        known = rows.setdefault((row["scene"], row["engine"], row["stepper"]), row)
        if row["cpu_s_per_s"]:
            known["cpu_s_per_s"] = f"{min(float(known['cpu_s_per_s']), float(row['cpu_s_per_s'])):.3g}"
with open(FOLDER / "cost.csv", "w", newline="") as file:
    writer = csv.DictWriter(file, next(iter(rows.values())), lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows.values())
