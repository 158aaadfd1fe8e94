#!/usr/bin/env python3
"""Runs the programs of docs/howto/read-the-tables.md on a report, and compares what they print with summary.json; and
the columns that it counts and names with those of the tables.

Usage: tables_page_test.py LCPBENCH PAGE
"""

import csv
import importlib.util
import json
import re
import subprocess
import sys
import tempfile
from pathlib import Path


def make_report(program, folder):
    run = [program, "run", "--store", "s.db", "--trials", "40"]
    for name in ["paper/monotone/exp1", "paper/copositive/exp1"]:
        run += ["--set", name]
    for name in ["lemke", "contact_lemke"]:
        run += ["--solver", name]
    for command in [run, [program, "report", "s.db", "--out", "report"]]:
        subprocess.run(command, cwd=folder, check=True, capture_output=True)
    return folder / "report"


def expected_lines(report):
    """The fastest reliable solver of each set: times of summary.json, who is reliable from cells.csv."""
    summary = json.loads((report / "summary.json").read_text())
    with open(report / "tables/cells.csv", newline="") as file:
        reliability = [row["reliability"] for row in csv.DictReader(file)]
    fastest = {}
    for cell, standing in zip(summary["cells"], reliability, strict=True):
        if standing != "reliable":
            continue
        solver = cell["solver"] + ("{" + cell["settings"] + "}" if cell["settings"] else "")
        fastest.setdefault(cell["set"], []).append((cell["time"]["all"]["median"], solver))
    best = {name: min(times) for name, times in fastest.items()}
    return [f"{name}: {best[name][1]}, {best[name][0]:.3g} s" for name in sorted(best)]


def columns_of(report, table):
    with open(report / "tables" / table, newline="") as file:
        return next(csv.reader(file))


def check_columns(text, report):
    """The page's table names each column of results.csv, in order; `_low` stands for the end of a name."""
    count = len(columns_of(report, "cells.csv"))
    assert f"`tables/cells.csv` has {count} columns" in " ".join(text.split()), f"cells.csv has {count} columns"
    named = []
    for row in re.findall(r"^\| (`.*?`) \|", text, re.MULTILINE):
        for name in re.findall(r"`(\w+)`", row):
            stem = named[-1].removesuffix("_low") if name[0] == "_" else ""
            named.append(stem + name)
    assert named == columns_of(report, "results.csv"), (named, columns_of(report, "results.csv"))


def main():
    program, page = sys.argv[1:]
    text = Path(page).read_text()
    blocks = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    assert len(blocks) == 2, f"{page}: {len(blocks)} programs instead of 2"
    with tempfile.TemporaryDirectory() as name:
        report = make_report(program, Path(name))
        check_columns(text, report)
        expected = expected_lines(report)
        assert len(expected) == 2, expected
        for block in blocks:
            if "import pandas" in block and importlib.util.find_spec("pandas") is None:
                print("pandas is not installed: its program was left out")
                continue
            done = subprocess.run([sys.executable, "-c", block], cwd=report, capture_output=True, text=True)
            assert done.returncode == 0, done.stderr
            assert done.stdout.splitlines() == expected, (done.stdout, expected)
            print("ran:", block.splitlines()[0])


if __name__ == "__main__":
    main()
