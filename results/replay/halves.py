#!/usr/bin/env python3
"""halves.py settings.csv: of each stepper, or engine by itself, the settings that are best on every second scene, judged on the others, beside its defaults.

Best: the fewest scenes lost, then the smallest geometric mean of the ways (slip, else drift, else penetration; 0.1 mm at least, 10 cm at most).
"""
import csv
import math
import sys

rows = [row for row in csv.DictReader(open(sys.argv[1])) if row["solver"] != "nothing"]
for row in rows:
    if row["solver"] == "engine":  # whose settings are options of the scene
        row["scene"], brace, options = row["scene"].partition("{")
        row["solver"] = row["engine"] + brace + options
scenes = list(dict.fromkeys(row["scene"] for row in rows))
of = {(row["solver"], row["scene"]): row for row in rows}
settings = list(dict.fromkeys(row["solver"] for row in rows))


def judged(solver, half):
    """Scenes lost, mean way [m], processor time for a second of all of them [s]."""
    chosen = [of[solver, scene] for scene in half]
    lost = sum(int(row["survived"]) < int(row["steps"]) for row in chosen)
    ways = [float(row["slip_m"] or row["drift_m"] or row["deepest_m"]) for row in chosen]
    mean = math.exp(sum(math.log(min(0.1, max(1e-4, way))) for way in ways) / len(ways))
    return lost, mean, sum(float(row["cpu_s_per_s"]) for row in chosen)


print("| chosen on | stepper | settings | lost there | lost on the others | mean way there | on the others | time there | on the others |")
print("|" + " --- |" * 9)
for name, half in (("scenes 1, 3, 5, ...", scenes[::2]), ("scenes 2, 4, 6, ...", scenes[1::2])):
    others = [scene for scene in scenes if scene not in half]
    for stepper in dict.fromkeys(solver.split("{")[0] for solver in settings):
        mine = [solver for solver in settings if solver.split("{")[0] == stepper]
        best = min(mine, key=lambda solver: judged(solver, half)[:2])
        for solver in dict.fromkeys((stepper, best)):
            there, elsewhere = judged(solver, half), judged(solver, others)
            words = ("the defaults" if solver == stepper else f"`{solver}`") + (", the best" if solver == best else "")
            print(f"| {name} | `{stepper}` | {words} | {there[0]} of {len(half)} | {elsewhere[0]} of {len(others)} | "
                  f"{1e3 * there[1]:.1f} mm | {1e3 * elsewhere[1]:.1f} mm | {1e3 * there[2]:.0f} ms | {1e3 * elsewhere[2]:.0f} ms |")
