#!/usr/bin/env python3
"""The errors of relaxation and softness over a sweep of the compliance: sweep.py LCPBENCH SCENE FILE.scenes >> errors.csv

Multiplies every compliance of the captured steps, and prints a row of errors.csv for each factor: the median stiffness
1 / (r h^2) of the contacts, the largest residual of the convex model, and the median and the largest error of relaxation
and of softness.
"""
import json
import subprocess
import sys
import tempfile

lcpbench, scene, file = sys.argv[1:4]
text = subprocess.run(["zstd", "-dc", file], capture_output=True, text=True, check=True).stdout
header, *lines = text.splitlines()
h = json.loads(header)["step_length"]


def pair(values):
    values = sorted(v for v in values if v is not None)
    return f"{values[len(values) // 2]:.1e},{values[-1]:.1e}" if values else ","


for factor in (1, 1 / 4, 1 / 16, 1 / 256, 0):
    steps, stiffness = [], []
    for line in lines:
        step = json.loads(line)
        problem = step["problem"]
        if not any(problem["edges"]):
            continue
        for name in ("compliance_n", "compliance_t"):
            problem[name] = [factor * r for r in problem[name]]
            if factor == 0:
                del problem[name]
        stiffness += [1 / (r * h * h) for r in problem.get("compliance_n", []) if r]
        step.pop("engine", None)
        steps.append(json.dumps(step, separators=(",", ":")))
    with tempfile.NamedTemporaryFile("w", suffix=".scenes") as changed:
        changed.write("\n".join([header, *steps]) + "\n")
        changed.flush()
        command = [lcpbench, "solve", changed.name, "--solver", "cone_ipm{cone=true,slip=none}", "--format", "json"]
        rows = json.loads(subprocess.run(command, capture_output=True, text=True).stdout)
    residual = max(row["errors"]["velocity_residual_m_per_s"] for row in rows)
    median = f"{sorted(stiffness)[len(stiffness) // 2]:.1e}" if stiffness else ""
    print(f"{scene},{h * 1e3:g},{factor:g},{median},{residual:.1e},"
          f"{pair(row.get('relaxation_m_per_s') for row in rows)},{pair(row.get('softness_m_per_s') for row in rows)}")
