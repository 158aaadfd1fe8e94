#!/usr/bin/env python3
"""Writes the captured steps of one island by size, slip ratio and redundancy, for the rules of `auto`.

    rules.py LCPBENCH TIMES REST WORK > rules.csv
        TIMES of `auto_regret all`, REST of `rest_steps auto contact_lemke`, WORK a folder for the problems

A row has the contacts times coordinates of a step, its slip ratio and redundancy (normals and tangents over its
coordinates) as docs/reference/solvers/auto.md defines them, whether rest is a solution and which solver rests, and the
time of each solver in microseconds, empty where it did not solve the step. The tables of README.md go to standard error.
"""
import csv
import json
import math
import pathlib
import subprocess
import sys

lcpbench, times, rest, work = sys.argv[1], sys.argv[2], sys.argv[3], pathlib.Path(sys.argv[4])
AT_REST = 1e-6  # of the fastest velocity at a contact before the impact


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def of_scene(scene):
    """Of each contact: N'v, the slips, mu, b; and the number of coordinates of the bodies that they touch."""
    def velocity(body, point):
        if body < 0:
            return [0, 0, 0]
        body = scene["bodies"][body]
        arm = [p - x for p, x in zip(point, body["position"])]
        return [v + w for v, w in zip(body["linear_velocity"], cross(body["angular_velocity"], arm))]

    contacts = []
    for c in scene["contacts"]:
        u = [a - b for a, b in zip(velocity(c["body_a"], c["point"]), velocity(c["body_b"], c["point"]))]
        slips = [dot(c["tangent"], u), dot(cross(c["normal"], c["tangent"]), u)] if c.get("edges", 0) > 0 else []
        contacts.append((dot(c["normal"], u), slips, c.get("mu", 0), c.get("b", 0)))
    touched = {c[body] for c in scene["contacts"] for body in ("body_a", "body_b")} - {-1}
    return contacts, 6 * len(touched)


def products(matrix, v):
    if isinstance(matrix, dict):
        rows, values, starts = matrix["rows"], matrix["values"], matrix["starts"]
        return [sum(values[k] * v[rows[k]] for k in range(a, b)) for a, b in zip(starts, starts[1:])]
    return [dot(column, v) for column in zip(*matrix)]


def touched_coordinates(problem):
    """Of the blocks of G that the normals touch."""
    if "G_blocks" not in problem:
        return len(problem["v"])
    N = problem["N"]
    nonzero = set(N["rows"]) if isinstance(N, dict) else {i for i, row in enumerate(N) if any(row)}
    first = total = 0
    for block in problem["G_blocks"]:
        if any(i in nonzero for i in range(first, first + len(block))):
            total += len(block)
        first += len(block)
    return total


def of_contact(problem):
    v = problem["v"]
    normal = products(problem["N"], v)
    slips = products(problem["D"], v) if "D" in problem else []
    contacts, first = [], 0
    for c, value in enumerate(normal):
        edges = problem["edges"][c] if "edges" in problem else 0
        mu = problem["mu"][c] if edges else 0
        contacts.append((value, slips[first:first + edges], mu, problem["b"][c] if "b" in problem else 0))
        first += edges
    return contacts, touched_coordinates(problem)


def features(problem):
    contacts, coordinates = of_scene(problem) if problem["kind"] == "scene" else of_contact(problem)
    approach = max(0, max(-(n + b) for n, _, _, b in contacts))
    slip = max([0] + [abs(s) for _, slips, _, _ in contacts for s in slips])
    mu = max(m for _, _, m, _ in contacts)
    rows = len(contacts) + 2 * sum(1 for _, _, m, _ in contacts if m > 0)
    limit = mu * approach
    return {"size": len(contacts) * coordinates, "slip_ratio": slip / limit if limit > 0 else math.inf,
            "redundancy": rows / coordinates}


steps = {}
for row in csv.DictReader(open(times)):
    step = steps.setdefault((row["set"], int(row["trial"])), {})
    is_solved = row["claim"] == "solved" and row["verified"] == "1"
    step[row["solver"]] = float(row["us"]) if is_solved else None
    if row["solver"] == "auto":
        step["is_one_island"] = "island" not in row["detail"]
velocities = {}  # after the impact over that before: of the least energy, auto and contact_lemke
for row in list(csv.reader(open(rest)))[1:]:
    velocities[row[0], int(row[1])] = [float(row[k]) < AT_REST for k in (5, 6, 8)]

SOLVERS = ["auto", "contact_lemke", "friction_ipm"]
out = csv.writer(sys.stdout, lineterminator="\n")
out.writerow(["set", "trial", "size", "slip_ratio", "redundancy", "rest", "auto_rests", "contact_lemke_rests"]
             + [name + "_us" for name in SOLVERS])
table = []
for (name, trial), step in steps.items():
    if not step["is_one_island"]:
        continue
    path = work / name.replace("/", "-") / f"{trial:06}.json"
    if not path.exists():
        subprocess.run([lcpbench, "generate", name, "--seed", "1", "--count", "1", "--first", str(trial), "--out",
                        path.parent], check=True, stdout=subprocess.DEVNULL)
    of_step = features(json.loads(path.read_text()))
    rests = velocities[name, trial]
    table.append(of_step | step | {"rest": rests[0], "lemke_rests": rests[2]})
    out.writerow([name, trial, of_step["size"], f"{of_step['slip_ratio']:.3g}", f"{of_step['redundancy']:.3g}"]
                 + [int(value) for value in rests] + [step[s] if step[s] is not None else "" for s in SOLVERS])



def row_of(*cells):
    print("| " + " | ".join(str(cell) for cell in cells) + " |", file=sys.stderr)


row_of("size", "slip ratio", "steps", "geometric mean", "least", "largest")
row_of(*["---"] * 6)
for low, high in [(0, 400), (400, 800), (800, 5000), (5000, math.inf)]:
    for sticks in (True, False):
        ratios = [math.log(t["friction_ipm"] / t["contact_lemke"]) for t in table
                  if low <= t["size"] < high and (t["slip_ratio"] <= 1) == sticks
                  and t["friction_ipm"] and t["contact_lemke"]]
        if ratios:
            numbers = [f"{math.exp(x):.3g}" for x in (sum(ratios) / len(ratios), min(ratios), max(ratios))]
            size = f"{low:,} to {high:,}" if high < math.inf else f"{low:,} or more"
            row_of(size, "at most 1" if sticks else "above 1", len(ratios), *numbers)
print(file=sys.stderr)
row_of("island", "slip ratio", "steps", "rest is a solution", "contact_lemke rests")
row_of(*["---"] * 5)
for words, is_of in [("size below 800, redundant", lambda t: t["redundancy"] > 1 and t["size"] < 800),
                     ("size below 800, not redundant", lambda t: t["redundancy"] <= 1 and t["size"] < 800),
                     ("size 800 or more", lambda t: t["size"] >= 800)]:
    for low, high in [(-1, 0.5), (0.5, 1), (1, 16), (16, math.inf)]:
        of_class = [t for t in table if is_of(t) and low < t["slip_ratio"] <= high]
        resting = [t for t in of_class if t["rest"]]
        if of_class:
            ratio = f"{max(low, 0)} to {high}" if high < math.inf else f"above {low}"
            row_of(words, ratio, len(of_class), len(resting), sum(t["lemke_rests"] for t in resting))
