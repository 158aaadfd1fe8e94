#!/usr/bin/env python3
"""steps.py LCPBENCH PASSES [PYTHON]: a second of five scenes in the ways of README's second table, into results/replay/steps.csv.

All ways are measured PASSES times, one pass after the other; of the processor times of a row the median is kept, with the least and the largest. PYTHON
has PyPI's mujoco: without it MuJoCo's row keeps what the file has.
"""
import csv
import json
import pathlib
import statistics
import subprocess
import sys
import tempfile

LCPBENCH, PASSES = sys.argv[1], int(sys.argv[2])
ROOT = pathlib.Path(__file__).resolve().parents[2]
TABLE = ROOT / "results/replay/steps.csv"
SCENES = ("pyramid-55", "wall", "mass-ratio-1e4", "gripper", "box-pile")
STEPPERS = ("exact", "exact{solver=auto{error=1e-4}}", "sequential_impulses", "sequential_impulses{iterations=50}")
KEPT = ("scene", "stepper", "engine", "steps", "survived", "drift_m", "slip_m", "deepest_m")


def replay(engine, steppers):
    """The rows of one pass."""
    with tempfile.TemporaryDirectory() as folder:
        options = [word for stepper in steppers for word in ("--stepper", stepper)] or ["--engine-solver"]
        subprocess.run([LCPBENCH, "replay", *SCENES, *options, "--engine", engine, "--steps", "200", "--out", folder], check=True,
                       stdout=subprocess.DEVNULL)
        with open(f"{folder}/summary.csv", newline="") as file:
            return [row for row in csv.DictReader(file) if row["stepper"] != "nothing"]


def versions():
    solvers = json.loads(subprocess.run([LCPBENCH, "solvers", "--format", "json"], check=True, capture_output=True, text=True).stdout)
    found = {solver["library"]: solver["version"] for solver in solvers if solver.get("version")}
    if len(sys.argv) > 3:
        found["MuJoCo"] = subprocess.run([sys.argv[3], "-c", "import mujoco; print(mujoco.__version__)"], check=True, capture_output=True,
                                         text=True).stdout.strip()
    return found


def main():
    ways = [("ode", STEPPERS), ("bullet", ()), ("dart", ())]
    if len(sys.argv) > 3:
        ways.append((f"external{{command={sys.argv[3]} {ROOT}/python/peers/mujoco_engine.py}}", ()))
    times, rows = {}, {}
    for _ in range(PASSES):
        for way in ways:
            for row in replay(*way):
                key = (row["scene"], row["stepper"], row["engine"])
                times.setdefault(key, []).extend([float(row["cpu_s_per_s"])] if row["cpu_s_per_s"] else [])  # an engine may tell none
                rows[key] = row
    version = versions()
    kept = []
    if len(sys.argv) <= 3 and TABLE.exists():
        with open(TABLE, newline="") as file:
            kept = [row for row in csv.DictReader(file) if row["engine"] == "MuJoCo"]
    with open(TABLE, "w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow((*KEPT, "version", "cpu_s_per_s", "least", "largest"))
        for key, row in rows.items():
            measured = (statistics.median(times[key]), min(times[key]), max(times[key])) if times[key] else ("", "", "")
            writer.writerow((*(row[name] for name in KEPT), version.get(row["engine"], ""), *measured))
        for row in kept:
            writer.writerow(row.values())


main()
