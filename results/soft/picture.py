#!/usr/bin/env python3
"""Draws the three errors over the compliance, a panel for each scene: picture.py < errors.csv > three-errors.svg"""
import csv
import math
import sys

PANEL, GAP, LEFT, TOP, HEIGHT, LOW, HIGH = 215, 20, 95, 50, 230, -15, 1
ERRORS = [("solver_largest_m_per_s", "solver (largest)", "#7a7a7a"),
          ("relaxation_median_m_per_s", "relaxation (median)", "#c0392b"),
          ("softness_median_m_per_s", "softness (median)", "#1f6fb4")]
DASHES = ["", "6 3", "2 3"]  # from the longest step to the shortest

rows = list(csv.DictReader(sys.stdin))
scenes = list(dict.fromkeys(row["scene"] for row in rows))
factors = list(dict.fromkeys(row["compliance"] for row in rows))
width = LEFT + len(scenes) * (PANEL + GAP)
out = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {TOP + HEIGHT + 75}" font-family="sans-serif" '
       'font-size="12"><rect width="100%" height="100%" fill="white"/>']


def text(x, y, words, anchor="middle", more=""):
    out.append(f'<text x="{x:.0f}" y="{y:.0f}" text-anchor="{anchor}" {more}>{words}</text>')


def height(error):
    return TOP + HEIGHT * (HIGH - max(math.log10(error), LOW)) / (HIGH - LOW)


for exponent in range(LOW, HIGH + 1, 3):
    text(LEFT - 8, height(10.0**exponent) + 4, "1e-3: 1 mm/s" if exponent == -3 else f"1e{exponent}", "end")
for k, scene in enumerate(scenes):
    left = LEFT + k * (PANEL + GAP)
    out.append(f'<rect x="{left}" y="{TOP}" width="{PANEL}" height="{HEIGHT}" fill="none" stroke="#999"/>'
               f'<path d="M{left} {height(1e-3):.1f}h{PANEL}" stroke="#ccc"/>')
    steps = list(dict.fromkeys(row["step_ms"] for row in rows if row["scene"] == scene))
    text(left + PANEL / 2, TOP - 8, f"{scene}: steps of {', '.join(steps)} ms", more='font-weight="bold" font-size="11"')
    place = {f: left + PANEL * (i + 0.5) / len(factors) for i, f in enumerate(factors)}
    for factor, x in place.items():
        name = f"1/{1 / float(factor):g}" if 0 < float(factor) < 1 else factor
        text(x, TOP + HEIGHT + 16, name)
    for key, _, colour in ERRORS:
        for step, dash in zip(steps, DASHES):
            points = [f"{place[row['compliance']]:.1f} {height(float(row[key])):.1f}" for row in rows
                      if (row["scene"], row["step_ms"]) == (scene, step)]
            out.append(f'<path d="M{"L".join(points)}" fill="none" stroke="{colour}" stroke-width="1.8" '
                       f'stroke-dasharray="{dash}"/>')
text(LEFT + (width - LEFT) / 2, TOP + HEIGHT + 36, "compliance, as a part of the engine's own (the last: hard contacts)")
text(LEFT - 85, 16, "error [m/s]; lines: longest step, dashes: half of it, dots: a quarter", "start")
for k, (_, name, colour) in enumerate(ERRORS):
    text(LEFT + 220 * k, TOP + HEIGHT + 62, f"&#9632; {name}", "start", f'fill="{colour}"')
print("\n".join([*out, "</svg>"]))
