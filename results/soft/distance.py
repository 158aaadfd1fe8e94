#!/usr/bin/env python3
"""How far an engine's answers are from the solution of its own model: distance.py LCPBENCH FILE.scenes SOLVER ENGINE

SOLVER finds the solution, ENGINE is `engine` or `engine{model=convex}`. Prints the number of steps, how many of the engine's
answers have the verdict solved, the median and the largest distance (the largest difference of a velocity over the largest
change of one in the step), and the largest certified distance of the optimum itself, in the energy norm. Steps that SOLVER
does not solve are left out, and counted.
"""
import json
import subprocess
import sys

lcpbench, file, solver, engine = sys.argv[1:5]
text = subprocess.run(["zstd", "-dc", file], capture_output=True, text=True, check=True).stdout
problems = [json.loads(line)["problem"] for line in text.splitlines()[1:]]
command = [lcpbench, "solve", file, "--solver", engine, "--solver", solver, "--format", "json"]
rows = json.loads(subprocess.run(command, capture_output=True, text=True).stdout)
found = {(row["problem"]["name"], row["solver"] == "engine"): row for row in rows}
distances, certified, solved, missed = [], [], 0, 0


def before(problem):
    if "v" in problem:
        return problem["v"]
    return [x for body in problem["bodies"] for x in body["linear_velocity"] + body["angular_velocity"]]


for problem in problems:
    own, best = found[problem["name"], True], found[problem["name"], False]
    solved += own["verdict"] == "solved"
    if best["verdict"] != "solved":
        missed += 1
        continue
    change = max(abs(a - b) for a, b in zip(best["velocity"], before(problem)))
    difference = max(abs(a - b) for a, b in zip(own["velocity"], best["velocity"]))
    distances.append(difference / change if difference else 0)
    if best["errors"]["optimum_distance"] is not None:
        certified.append(best["errors"]["optimum_distance"])
distances.sort()
print(f"{len(problems)} | {solved} | {distances[len(distances) // 2]:.1e} | {distances[-1]:.1e} | "
      f"{max(certified, default=float('nan')):.1e} on {len(certified)} | without a solution: {missed}")
