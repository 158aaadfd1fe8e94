#!/usr/bin/env python3
"""Fits the rows of native/auto/prediction_rows.inc to a table of `auto_table measure`.

    auto_fit.py fit TABLE     the rows, as C++
    auto_fit.py check TABLE   leaves one family after the other out of the fit: the error of the predictions on it

Each row is a linear least squares fit of logarithms to base 2, with a small ridge: of the time of load() by the sizes,
which are the first features, and of the weighted work of a solve by all. A method that did not reach the residual
counts as if it had taken four times what it did.
"""
import math
import statistics
import sys
from collections import namedtuple

DIGITS = (2, 4, 6, 9)  # of the residuals that methods were measured to
SIZES = 5  # kSizes of native/auto/features.h
MEASURED = 8  # features beside the constant, which is first, and the digits, which are last
METHODS = 6
DENSE = (0, 1)  # active_set and contact_lemke know no error: one measurement stands for all digits
PENALTY = 4
RIDGE = 1e-2  # of the squared coefficients, for each row of the table; features are of the order of 10
LEAST_NS = 1e4  # a solve of less is too short for the clock to tell what a unit of work takes

# By name, method and friction, in the order of the file.
ROWS = (("kContactLemke", 1, 1), ("kFrictionIpm", 3, 1), ("kPsor", 4, 1), ("kContactIpm", 5, 1),
        ("kActiveSet", 0, 0), ("kVelocityIpm", 2, 0), ("kSweeps", 4, 0))

# What one method took for one problem to one residual. `reached` is 0 where `work` is what it had done when it gave up.
Cost = namedtuple("Cost", "set method frictional features load_ns work solve_ns reached")


def costs_of_line(line):
    words = line.split(",")
    method = int(words[2])
    if not 0 <= method < METHODS:
        raise ValueError("no such method")
    first = 5 + MEASURED
    measured = [float(word) for word in words[5:first]]
    results = [tuple(map(float, words[k:k + 3])) for k in range(first, len(words), 3)]
    if len(results) != (1 if method in DENSE else len(DIGITS)):
        raise ValueError("results of other residuals")
    return [Cost(words[0], method, int(words[3]), [1.0, *measured, digits], float(words[4]), *result)
            for digits, result in zip(DIGITS, results * len(DIGITS))]


def read_costs(path):
    try:
        with open(path, encoding="utf-8") as file:
            lines = file.readlines()[1:]  # without the names of the columns
    except OSError as error:
        sys.exit(f"{path}: cannot be read: {error.strerror}")
    costs = []
    for number, line in enumerate(lines, start=2):
        try:
            costs += costs_of_line(line)
        except (ValueError, IndexError):
            sys.exit(f"{path}: line {number} is no row of measured costs")
    return costs


def solved(matrix, right):
    """Of a symmetric positive definite matrix."""
    rows = [row + [value] for row, value in zip(matrix, right)]
    for k, pivot in enumerate(rows):
        for row in rows[k + 1:]:
            factor = row[k] / pivot[k]
            row[k:] = [x - factor * y for x, y in zip(row[k:], pivot[k:])]
    solution = [0.0] * len(rows)
    for k in reversed(range(len(rows))):
        known = sum(rows[k][j] * solution[j] for j in range(k + 1, len(rows)))
        solution[k] = (rows[k][-1] - known) / rows[k][k]
    return solution


def least_squares(costs, values, count):
    """Rounded to three digits, which are far more than the fit knows."""
    columns = [[cost.features[k] for cost in costs] for k in range(count)]
    normal = [[sum(x * y for x, y in zip(a, b)) for b in columns] for a in columns]
    for k in range(count):
        normal[k][k] += RIDGE * max(len(costs), 1)
    return [round(x, 3) for x in solved(normal, [sum(x * y for x, y in zip(a, values)) for a in columns])]


def log_work(cost, weight):
    return math.log2(max(weight * cost.work, 1.0))


def fit_row(costs, method, frictional):
    """Nanoseconds for a unit of work, and the coefficients for load and solve; of a dense method the sizes tell the load."""
    own = [cost for cost in costs if cost.method == method and cost.frictional == frictional]
    weights = [cost.solve_ns / cost.work for cost in own if cost.solve_ns >= LEAST_NS and cost.work > 0]
    weight = round(statistics.median(weights), 3) if weights else 1.0
    load = [] if method in DENSE else least_squares(own, [math.log2(max(cost.load_ns, 1.0)) for cost in own], SIZES)
    solve = [log_work(cost, weight if cost.reached else PENALTY * weight) for cost in own]
    return weight, load, least_squares(own, solve, MEASURED + 2)


def rows_text(costs):
    text = ""
    for name, method, frictional in ROWS:
        weight, load, solve = fit_row(costs, method, frictional)
        load, solve = (", ".join(f"{x:.3f}" for x in row) for row in (load, solve))
        text += f"inline constexpr Row {name}{{{weight:.3f}, {{{load}}},\n    {{{solve}}}}};\n"
    return text


def family_of(cost):
    """scene/stack of scene/stack/ode"""
    return "/".join(cost.set.split("/")[:2])


def check(costs):
    print("family left out,method,frictional,problems,measured over predicted,spread")
    for family in sorted({family_of(cost) for cost in costs}):
        others = [cost for cost in costs if family_of(cost) != family]
        left_out = [cost for cost in costs if family_of(cost) == family and cost.reached]
        for method, frictional in sorted({(cost.method, cost.frictional) for cost in left_out}):
            weight, _, solve = fit_row(others, method, frictional)
            errors = [log_work(cost, weight) - sum(x * y for x, y in zip(solve, cost.features))
                      for cost in left_out if (cost.method, cost.frictional) == (method, frictional)]
            spread = statistics.stdev(errors) if len(errors) > 1 else math.nan
            print(f"{family},{method},{frictional},{len(errors)},{2 ** statistics.mean(errors):.2f},{2 ** spread:.2f}")


if __name__ == "__main__":
    if len(sys.argv) != 3 or sys.argv[1] not in ("fit", "check"):
        sys.exit("usage: auto_fit.py fit|check TABLE")
    table = read_costs(sys.argv[2])
    if sys.argv[1] == "fit":
        print(rows_text(table), end="")
    else:
        check(table)
