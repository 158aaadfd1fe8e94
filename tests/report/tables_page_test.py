#!/usr/bin/env python3
"""Runs the program of docs/howto/report.md on a report, and compares what it prints with summary.json, the tables of
cells with it, and the columns that the page names with those of results.csv.

Usage: tables_page_test.py LCPBENCH PAGE
"""

import csv
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


def check_cells(report):
    """cells.csv has the numbers of summary.json, as far as its column `label`."""
    with open(report / "tables/cells.csv", newline="") as file:
        columns, *rows = csv.reader(file)
    columns = columns[:columns.index("label")]
    assert len(columns) > 30, columns
    for cell, row in zip(json.loads((report / "summary.json").read_text())["cells"], rows, strict=True):
        for column, text in zip(columns, row):
            value = cell
            for name in column.split("."):
                value = value[name]
            same = text == (value or "") if value is None or isinstance(value, str) else float(text) == value
            assert same, (column, text, value)


def columns_of(report, table):
    with open(report / "tables" / table, newline="") as file:
        return next(csv.reader(file))


def check_columns(text, report):
    """The page's list names each column of results.csv, in order; `_low` stands for the end of a name."""
    named = []
    for item in re.findall(r"^- (`[^:]*`):", text.split("### Results in")[1].split("\n## ")[0], re.MULTILINE):
        for name in re.findall(r"`(\w+)`", item):
            stem = named[-1].removesuffix("_low") if name[0] == "_" else ""
            named.append(stem + name)
    assert named == columns_of(report, "results.csv"), (named, columns_of(report, "results.csv"))


def main():
    program, page = sys.argv[1:]
    text = Path(page).read_text()
    (block,) = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    with tempfile.TemporaryDirectory() as name:
        report = make_report(program, Path(name))
        check_cells(report)
        check_columns(text, report)
        expected = expected_lines(report)
        assert len(expected) == 2, expected
        done = subprocess.run([sys.executable, "-c", block], cwd=report, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        assert done.stdout.splitlines() == expected, (done.stdout, expected)


if __name__ == "__main__":
    main()
