#!/usr/bin/env python3
"""Writes ratios.csv and ratios.provenance.json from the JSON files of `lcpbench bench`.

    collect_ratios.py FOLDER OUT      FOLDER has ratios-*.json, one run of one solver beside one reference each

What all runs have in common stands in the provenance, once; commit, start and command of each run stand in its row.
"""
import csv
import json
import pathlib
import sys

folder, out = map(pathlib.Path, sys.argv[1:])
own = ["commit", "started", "command"]
rows, common = [], None
for path in sorted(folder.glob("ratios-*.json")):
    run = json.loads(path.read_text())
    provenance = {key: value for key, value in run["provenance"].items() if key not in own}
    if common not in (None, provenance):
        sys.exit(f"{path}: made by another machine or build than the runs before")
    common = provenance
    for cell in run["cells"]:
        rows.append({"reference": run["reference"]} | cell | {key: run["provenance"][key] for key in own})
if not rows:
    sys.exit(f"{folder}: no ratios-*.json")
with open(out / "ratios.csv", "w", newline="") as file:
    writer = csv.DictWriter(file, rows[0].keys(), lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
(out / "ratios.provenance.json").write_text(json.dumps(common) + "\n")
