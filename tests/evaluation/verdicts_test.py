#!/usr/bin/env python3
"""lcpbench solve agrees with the second judge, which was written from docs/explanation/verdicts.md alone.

usage: verdicts_test.py LCPBENCH
"""
import json
import math
import os
import random
import subprocess
import sys
import tempfile

import second_judge

HERE = os.path.dirname(os.path.abspath(__file__))
MEASURES = ("velocity_residual_relative", "velocity_residual_m_per_s", "violation_m_per_s", "work_gain_j",
            "backward_row_norm", "returned_velocity_error", "proof_margin")


def contact(v, N, G, **friction):
    return {"kind": "contact", "v": v, "N": N, "G": G, **friction}


def factored(v, N, X):
    return {"kind": "contact", "v": v, "N": N, "G_factors": {"X": X, "alpha": [1] * len(X[0])}}


def lcp(M, q, **bounds):
    return {"kind": "lcp", "M": M, "q": q, **bounds}


def identity(n, values=None):
    return [[(values[i] if values else 1) if i == j else 0 for j in range(n)] for i in range(n)]


def velocity_cases(draw):
    """Contacts with z and a velocity: near and far from the one of z, where all cancels, and in one coordinate."""
    pressed = contact([0, 0, 0], [[1, -1], [0.3, -0.3], [0.1, -0.1]], [[4, 1, -2], [1, 5, 3], [-2, 3, 7]])
    apart = contact([0, 0], [[1, -1, 0], [0, 0, 1]], identity(2))
    for size in (0, 1e-17, 1e-15, 1e-14, 1e-11, 1e-6):
        yield pressed, [2, 2], [size, 0, 0]
        yield apart, [2, 2, 0], [size, 0]
        yield apart, [2, 2, 0], [0, size]  # nothing pushes there
    yield contact([1, -1], identity(2), identity(2)), [0, 1], [777, 888]
    for size in (1e-17, 1e-15, 1e-9):  # at rest beside what moves, in an island with it or not
        yield contact([-1, 0], [[1], [0]], [[4, 1], [1, 5]]), [1], [-0.736842105263158, size - 0.0526315789473684]
        yield contact([-1, 0, 0], [[1], [0], [0]], identity(3)), [1], [0, size, 0]
        yield contact([0, 1, 0], [[1], [0], [0]], identity(3)), [0], [0, 1, size]
    # The energy of 1e9 kg could give 1 kg beside it a speed of 3e4 m/s: 1e-8 of that is 3e-4 m/s.
    for size in (1e-9, 2e-8, 4e-8, 1e-3):
        yield contact([-1, 0], [[1], [-1]], [[1e9, 0], [0, 1]]), [1], [-1 + 1e-9, size - 1]
        yield contact([-1, 0, 0], [[1], [0], [0]], [[1e9, 0, 0], [0, 1, 0], [0, 0, 1]]), [1e9], [0, size, 1e-13]
    # At rest but for rounding: nothing below 1e-12 m/s is wrong.
    for size in (1e-15, 9e-13, 1.1e-12):
        yield contact([1e-15, 0], [[0], [1]], identity(2)), [0], [1e-15 + size, 0]
        yield contact([1e-15, -0.02], [[0], [1]], [[0.3, 0], [0, 0.3]]), [0.006], [size, 0]
    for _ in range(40):
        G = [[draw.randint(3, 9) if i == j else 0 for j in range(3)] for i in range(3)]
        G[0][1] = G[1][0] = draw.randint(-2, 2)
        problem = contact([draw.randint(-40, 40) / 16 for _ in range(3)],
                          [[draw.randint(-8, 8) / 4 for _ in range(2)] for _ in range(3)], G)
        z = [draw.randint(0, 9) / 8, draw.randint(0, 9) / 8]
        data = second_judge.Contact(problem)
        v_plus = [float(v + sum(r[a] * second_judge.Fraction(f) for r, f in zip(data.responses, z)))
                  for a, v in enumerate(data.v)]
        v_plus[draw.randint(0, 2)] += draw.uniform(-1, 1) * 10.0 ** draw.randint(-17, -2)
        yield problem, z, v_plus


def known_cases():
    """Problems with z: islands of different scale, the floor, blocks, dust, no violation at all."""
    two = contact([20000, -1], identity(2), identity(2))
    yield two, [0, 0]
    yield two, [0, 1]
    yield two, [0, 1.00005]
    yield contact([20000, -1], identity(2), [[1, 0.5], [0.5, 1]]), [0, 0]
    blocks = lcp(identity(2), [-1e10, -1])
    yield blocks, [1e10, 0]
    yield blocks, [1e10, 1]
    yield blocks, [1e10, 1 + 1e-8]
    cancels = contact([0.1, 0.3], [[-3], [1]], identity(2))
    for impulse in (0, 5.55e-18, 1e-16, 1e-13):
        yield cancels, [impulse]
    for speed in (1e-15, 1e-12, 1e-11, 1e-6):  # at rest but for rounding
        slips = contact([speed, -0.02], [[0], [1]], [[0.3, 0], [0, 0.3]], D=[[1, -1], [0, 0]], edges=[2], mu=[1])
        yield slips, [0.006, 0, 0, 0]
        yield contact([-speed], [[1]], [[1]]), [0]
    for gap in (0, 5, 1e3, 1e6):  # an open row beside one that is violated by about what may be
        yield contact([-1, 0.5], [[1, 0.25], [0, 1]], [[2, 0.5], [0.5, 1]], b=[0, gap]), [1.75 * (1 - 0.99e-4), 0]
    for press in (1, 1e4, 1e7, 1e12):  # opposite impulses, however large
        yield contact([-1], [[1, -1]], [[1]], b=[0, 2]), [1 + press, press]
        yield contact([-1], [[1, -1]], [[1]], b=[0, 0]), [press, press]
        yield lcp([[0, 1, -1], [-1, 0, 0], [1, 0, 0]], [0, 2, -5]), [3, press, press]
        yield lcp([[1, -1], [-1, 1]], [-1, 1]), [press + 1, press]
        yield lcp([[1, -1], [-1, 1]], [-1, 1.001]), [press + 1, press]
    rests = lcp(identity(2), [1, 0], lower=[0, None], upper=[None, None], friction_of=[None, 0], mu=[None, 0.5])
    for normal in (-1e-17, -1e-5, 0):  # the limits of the friction row cross
        yield rests, [normal, 0]
    # An offset along the tangent is no speed of the bodies: beside it 1e-9 m/s are still 1e-9 m/s.
    for offset in (0, 0.8, 1e6):
        slow = contact([0, -1e-9], [[0], [1]], identity(2), D=[[1, -1], [0, 0]], edges=[2], mu=[0.5],
                       offset_t=[offset, 0], compliance_n=[0.5])
        yield slow, [0, 0, 0, 0]
        yield slow, [6.667e-10, 0, 0, offset]
    dusty = lcp([[1, 0, 0], [0, 1, 0.5], [0, 0.5, 1]], [-1e10, -1, 1])
    for dust in (0, -1e-12, 1e-12, -1e-6):
        yield dusty, [1e10, 1, dust]
    sliders = contact([1000, -1000, 1, -2], [[0, 0], [1, 0], [0, 0], [0, 1]], identity(4), mu=[0.5, 0.5], edges=[2, 2],
                      D=[[1, -1, 0, 0], [0] * 4, [0, 0, 1, -1], [0] * 4])
    yield sliders, [1000, 2, 0, 500, 0, 1, 500, 0]
    yield sliders, [1000, 2, 0, 500, 0, 0, 500, 0]
    yield sliders, [1000, 2, 0, 500, 0, 1, 400, 0]
    yield contact([0, 0], identity(2), identity(2), b=[-1, 2]), [1, 0]
    yield contact([0, -3], identity(2), identity(2), b=[-1e-9, 2]), [0, 1]
    cancelled = contact([0.1, 0.3], [[-3], [1]], identity(2), b=[5e-17])
    for impulse in (0, 1e-18, 1e-13):
        yield cancelled, [impulse]
    nearly_dependent = factored([-1, 1], [[1], [-1]], [[1, 1], [1, 1 + 2.0**-52]])
    for impulse in (0, 2.0**-105, 3.2e32):
        yield nearly_dependent, [impulse]
    light = factored([-1, -1], [[1], [1]], [[1, 1], [0, 1e-14]])
    for impulse in (0, 1e-28, 0.5):
        yield light, [impulse]
    dependent = factored([-1, 0, 0], [[1], [0], [0]], [[-1, 1, 0], [2, -1, 1], [1, 0, 1]])
    for impulse in (0, 1, 9):
        yield dependent, [impulse]
    yield contact([0, 0], identity(2), identity(2)), [0, 0]
    yield contact([0, 0], identity(2), identity(2)), [0, 1e-20]
    yield lcp(identity(2), [1, 1]), [0, 1e-300]


def random_cases(draw):
    """Contacts of one to three islands, bare LCPs of one to three blocks; right answers, near ones, wild ones."""
    def number():
        return draw.randint(-40, 40) / 16

    def dust(value):
        kind = draw.random()
        if kind < 0.4:
            return value
        if kind < 0.7:
            return value * (1 + draw.uniform(-1, 1) * 10.0 ** draw.randint(-15, -1))
        return value + draw.choice((0, draw.uniform(-1, 1) * 10.0 ** draw.randint(-18, 0)))

    for _ in range(30):
        islands = draw.randint(1, 3)
        ngc, nc = 2 * islands, 2 * islands
        scale = [10.0 ** draw.randint(-6, 6) for _ in range(islands)]
        v = [number() * scale[i // 2] for i in range(ngc)]
        N = [[number() if row // 2 == column // 2 else 0 for column in range(nc)] for row in range(ngc)]
        G = [[0] * ngc for _ in range(ngc)]
        for k in range(islands):
            G[2 * k][2 * k], G[2 * k + 1][2 * k + 1] = draw.randint(2, 9), draw.randint(2, 9)
            G[2 * k][2 * k + 1] = G[2 * k + 1][2 * k] = draw.randint(-1, 1)
        edges = [draw.choice((0, 2)) for _ in range(nc)]
        friction = {}
        if any(edges):
            columns = []
            for c in range(nc):
                if edges[c]:
                    d = [number() if row // 2 == c // 2 else 0 for row in range(ngc)]
                    columns += [d, [-entry for entry in d]]
            friction = {"mu": [draw.randint(0, 8) / 8 if edges[c] else 0 for c in range(nc)], "edges": edges,
                        "D": [list(row) for row in zip(*columns)]}
        if draw.random() < 0.5:
            friction["b"] = [number() * scale[c // 2] for c in range(nc)]
        if draw.random() < 0.3:
            friction["compliance_n"] = [abs(number()) for _ in range(nc)]
        if any(edges) and draw.random() < 0.3:
            friction["compliance_t"] = [abs(number()) if edges[c] else 0 for c in range(nc)]
            friction["offset_t"] = [number() if edges[c // 2] and c % 2 == 0 else 0 for c in range(2 * nc)]
        n = nc + sum(edges) + sum(1 for count in edges if count)
        yield contact(v, N, G, **friction), [dust(abs(number())) if draw.random() < 0.5 else dust(0) for _ in range(n)]
    for _ in range(30):
        sizes = [draw.randint(1, 3) for _ in range(draw.randint(1, 3))]
        n = sum(sizes)
        M = [[0] * n for _ in range(n)]
        start, z = 0, []
        for size in sizes:
            for i in range(start, start + size):
                for j in range(start, start + size):
                    M[i][j] = number()
            z += [draw.randint(1, 9) * 2.0 ** draw.randint(-9, 9) if draw.random() < 0.6 else 0 for _ in range(size)]
            start += size
        # A planted solution: w = 0 where z > 0, else what makes q.
        q = [float((0 if z[i] > 0 else draw.randint(0, 5)) -
                   sum(second_judge.Fraction(M[i][j]) * second_judge.Fraction(z[j]) for j in range(n)))
             for i in range(n)]
        yield lcp(M, q), z if draw.random() < 0.3 else [dust(value) for value in z]


    for _ in range(80):  # mixed, of bounds on every row: an LCP in z >= 0 is handed to solvers that take no others
        n = draw.randint(1, 4)
        M = [[number() for _ in range(n)] for _ in range(n)]
        lower, upper = [], []
        for _ in range(n):
            low, high = sorted((number(), number()))
            low, high = draw.choice(((0, None), (low, None), (None, high), (low, high), (low, low)))
            lower.append(low)
            upper.append(high)
        friction = {}
        if n > 1 and draw.random() < 0.5:
            lower[:2], upper[:2] = [0, None], [None, None]
            friction = {"friction_of": [None, 0] + [None] * (n - 2), "mu": [None, 0.5] + [None] * (n - 2)}
        z = [dust(draw.choice((low or 0, low or 0 if high is None else high, number())))
             for low, high in zip(lower, upper)]
        z = unreduced(reduced(z, lower, upper, friction), lower, upper, friction)
        q = [float(-sum(second_judge.Fraction(a) * second_judge.Fraction(b) for a, b in zip(row, z))) for row in M]
        q = [draw.choice((value, value, value + number())) for value in q]
        yield lcp(M, q, lower=lower, upper=upper, **friction), z


def rows(columns, lower, upper, **given):
    """Bounded rows by their directions."""
    return {"R": [list(entries) for entries in zip(*columns)], "lower": lower, "upper": upper, **given}


def known_row_cases():
    """Bounded rows with z: every kind, and every way to the lever of an angle."""
    hinge = rows([[1]], [-0.03], [0.03], unit=["rad"])
    for impulse in (0, -0.03, -0.03 * (1 + 1e-5), -0.0301, 0.03):
        yield contact([0.1], [[]], [[1]], rows=hinge), [impulse]
        yield contact([0.02], [[]], [[1]], rows=hinge), [impulse]
    loop = rows([[1, -1], [1, -1]], [None, None], [None, None])
    for size in (0, 1, 1e6):
        yield contact([1, 0], [[], []], identity(2), rows=loop), [size - 0.25, -size - 0.25]
    drive = rows([[1]], [-0.2], [0.2], b=[-1], compliance=[1])
    for impulse in (0, 0.2, 0.5):
        yield contact([0], [[]], [[1]], rows=drive), [impulse]
    loaded = rows([[1, -0.1], [0, 1]], [0, None], [None, None], friction_of=[None, 0], mu=[0, 0.2], unit=["m", "rad"])
    for torque in (0.1, 0.2, 0.3, -0.1):
        yield contact([-1, 0], [[], []], identity(2, [1, 0.01]), rows=loaded), [1, torque]
        yield contact([-1, 0], [[], []], identity(2, [1, 0.01]), rows=loaded), [-1, torque]
    # A row that moves nothing: bounds, and none.
    for lower, upper in ((0, None), (None, 0), (-1, 2), (None, None)):
        for b in (0, 0.5, -0.5):
            still = rows([[0, 0], [0, 1]], [lower, -0.1], [upper, 0.1], b=[b, 0], unit=["rad", "m"])
            yield contact([1, 0.1], [[1], [0]], identity(2), rows=still), [0, 2, -0.1]
            massless = rows([[0, 1]], [lower], [upper], b=[b], unit=["rad"])
            yield {**factored([1, 0], [[1], [0]], [[2], [0]]), "rows": massless}, [0, 3]
    # The lever: of the contacts that the row moves, one, two and three; of its island; of its rows in m; 1.
    turns = rows([[0, 0, 1], [1, 0, 0]], [-1, None], [1, None], unit=["rad", "m"])
    coupled = [[2, 0, 1], [0, 3, 0], [1, 0, 4]]
    for N in ([[], [], []], [[0], [1], [0]], [[1], [0], [1]], [[1, 0], [1, 0], [1, 2]], [[1, 0, 0], [0, 1, 0], [1, 2, 3]]):
        for inertia in (identity(3, [2, 3, 4]), coupled):
            for push in (0, 1):
                yield (contact([0.5, -0.25, 1], N, inertia, rows=turns), [0.25] * len(N[0]) + [push, 0.5])
    # A motor at rest that is asked for nothing but speed gives the scale; a fast row gives the floor.
    for speed in (1e-10, 1, 1e6):
        spins = rows([[1, 0], [0, 1]], [-1e-3, None], [1e-3, None], b=[-speed, 0], unit=["rad", "m"])
        yield contact([0, 1e-7], [[], []], identity(2), rows=spins), [1e-3, 0]
        fast = rows([[1, 0]], [0], [None], unit=["rad"])
        yield contact([speed, -1e-5], [[0], [1]], [[2, 1], [1, 2]], rows=fast), [0, 0]


def random_row_cases(draw):
    """Bounded rows of every kind beside contacts of 0 or 2 edges, whose offsets make an answer right; it, and near ones."""
    def number():
        return draw.randint(-40, 40) / 16

    for _ in range(150):
        ngc, nc, m = draw.choice((2, 4)), draw.randint(0, 2), draw.randint(1, 4)
        half = [draw.randint(0, ngc // 2 - 1) for _ in range(nc + m)]  # the island of each contact and row
        G = [[0] * ngc for _ in range(ngc)]
        for k in range(0, ngc, 2):
            G[k][k], G[k + 1][k + 1] = draw.randint(2, 9), draw.randint(2, 9)
            G[k][k + 1] = G[k + 1][k] = draw.randint(-1, 1)

        def direction(part):
            return [number() if k // 2 == part else 0 for k in range(ngc)]

        normals = [direction(part) for part in half[:nc]]
        edges = [draw.choice((0, 2)) for _ in range(nc)]
        tangents = [direction(part) for part in half[:nc]]
        mu = [draw.randint(0, 8) / 8 if count else 0 for count in edges]
        R = [direction(part) for part in half[nc:]]
        for k in range(m):
            kind = draw.random()
            if kind < 0.1:
                R[k] = [0] * ngc
            elif kind < 0.2:
                R[k] = [number() for _ in range(ngc)]
            elif kind < 0.4 and k > 0:
                R[k] = [draw.choice((-2, 1)) * entry for entry in R[k - 1]]
        lower, upper = [None] * m, [None] * m
        friction_of, row_mu = [None] * m, [0] * m
        for k in range(m):
            low, high = -abs(number()), abs(number()) + 1 / 16
            lower[k], upper[k] = draw.choice(((None, None), (0, None), (None, 0), (low, None), (low, high), (-high, high)))
        if m > 1 and draw.random() < 0.5:
            lower[0], upper[0] = 0, draw.choice((None, 2))
            lower[m - 1] = upper[m - 1] = None
            friction_of[m - 1], row_mu[m - 1] = 0, draw.randint(0, 8) / 8
        f_N = [draw.choice((0, abs(number()))) for _ in range(nc)]
        f_T = [draw.choice((-1, 1)) * mu[c] * f_N[c] if edges[c] else 0 for c in range(nc)]
        f_R, w_R = [], []
        for k in range(m):
            low, high = lower[k], upper[k]
            if friction_of[k] is not None:
                low, high = -row_mu[k] * f_R[0], row_mu[k] * f_R[0]
            state = draw.choice(("lower", "upper", "between"))
            if state == "lower" and low is not None:
                f_R.append(low)
                w_R.append(abs(number()))
            elif state == "upper" and high is not None:
                f_R.append(high)
                w_R.append(-abs(number()))
            else:
                f_R.append(min(max(number(), -math.inf if low is None else low), math.inf if high is None else high))
                w_R.append(0)
        compliance = [draw.choice((0, 0, 0, 0.5, 3)) for _ in range(m)]
        r_n, r_t = [draw.choice((0, 0, 0.25)) for _ in range(nc)], [draw.choice((0, 0.25)) * (count > 0) for count in edges]
        # Offsets such that these impulses are right: sliding contacts slide, the others press or part.
        v = [number() for _ in range(ngc)]
        fraction = second_judge.Fraction
        pushes = [sum((fraction(J[a]) * fraction(f) for J, f in zip(normals + tangents + R, f_N + f_T + f_R)), fraction(0))
                  for a in range(ngc)]
        change = second_judge.solve_exactly([[fraction(entry) for entry in row] for row in G], [pushes])[0]
        v_plus = [before + by for before, by in zip(v, change)]

        def along(J):
            return second_judge.dot(second_judge.exact(J), v_plus)

        slips = [draw.choice((0, abs(number()))) * (-1 if f > 0 else 1) for f in f_T]
        b_N = [float((0 if f > 0 else abs(number())) - along(J) - fraction(r * f)) for J, f, r in zip(normals, f_N, r_n)]
        offset_t = [entry for J, f, r, count, slip in zip(tangents, f_T, r_t, edges, slips)
                    for entry in (float(fraction(slip) - along(J) - fraction(r) * fraction(f)) if count else 0, 0)]
        b_R = [float(fraction(w) - along(J) - fraction(r) * fraction(f)) for J, f, r, w in zip(R, f_R, compliance, w_R)]
        given = {"rows": rows(R, lower, upper, b=b_R, compliance=compliance,
                              unit=[draw.choice(("m", "rad")) for _ in range(m)])}
        if any(of is not None for of in friction_of):
            given["rows"].update(friction_of=friction_of, mu=row_mu)
        if nc:
            given.update(b=b_N, compliance_n=r_n)
        if any(edges):
            D = [[sign * entry for entry in T] for T, count in zip(tangents, edges) if count for sign in (1, -1)]
            given.update(D=[list(row) for row in zip(*D)], edges=edges, mu=mu, compliance_t=r_t, offset_t=offset_t)
        f_D = [max(sign * f, 0) for f, count in zip(f_T, edges) if count for sign in (1, -1)]
        slopes = [abs(slip) for slip, count in zip(slips, edges) if count]
        z = f_N + f_D + slopes + f_R
        yield contact(v, [list(row) for row in zip(*normals)] or [[] for _ in v], G, **given), z
        kind = draw.random()
        if kind < 0.3:
            z = [value * (1 + draw.uniform(-1, 1) * 10.0 ** draw.randint(-15, -1)) for value in z]
        elif kind < 0.9:
            i = draw.randrange(len(z))
            z[i] += draw.choice((-1, 1)) * 10.0 ** draw.randint(-12, 0)
        else:
            z = [0] * len(z)
        yield contact(v, [list(row) for row in zip(*normals)] or [[] for _ in v], G, **given), z


def row_proof_cases():
    """Contacts with bounded rows, zero impulses and a vector that proves that there is no solution, or nothing."""
    def held(lower, upper, b, u, compliance=(0, 0), v=(0,)):
        return (contact(list(v), [[] for _ in v], identity(len(v)),
                        rows=rows([[1] + [0] * (len(v) - 1)] * 2, lower, upper, b=b, compliance=list(compliance))),
                [0, 0], u)

    none = [None, None]
    for u in ([1, -1], [-1, 1]):
        yield held(none, none, [0, 1], u)
        yield held(none, none, [0, -1], u)
        yield held(none, none, [0, 1], u, compliance=(0, 1))
        yield held([0, None], [None, 0], [-2, -1], u)  # v+ >= 2, v+ <= 1
        yield held([None, 0], [0, None], [-2, -1], u)  # v+ <= 2, v+ >= 1
        yield held([0, -5], [None, 5], [-2, -1], u)
        yield held([None, None], [None, 3], [-2, -1], u)
    yield held(none, none, [0, 1], [1, -1.0000000001])  # moves something
    # A contact that is closed by a joint.
    closed = rows([[1]], [None], [None], b=[0])
    for contact_offset, weights in ((-1, [1, -1]), (1, [1, -1]), (-1, [-1, 1])):
        yield contact([0], [[1]], [[1]], b=[contact_offset], rows=closed), [0, 0], weights
    loaded = rows([[1], [1]], [0, None], [None, None], friction_of=[None, 0], mu=[0, 0.5], b=[-2, 0])
    yield contact([0], [[]], [[1]], rows=loaded), [0, 0], [1, -1]  # friction proves nothing
    massless = rows([[0, 1]], [None], [None], b=[1])
    yield {**factored([0, 0], [[1], [0]], [[2], [0]]), "rows": massless}, [0, 0], [0, -1]


def reduced(z, lower, upper, friction):
    """z of a mixed LCP without free unknowns as the program's reduction to unknowns >= 0 has it; slacks are zero."""
    x, slacks = [], 0
    for i, (value, low, high) in enumerate(zip(z, lower, upper)):
        if friction and friction["friction_of"][i] is not None:
            x += [max(value, 0), max(-value, 0)]
            slacks += 1
        elif low is None:
            x.append(high - value)
        elif low != high:
            x.append(value - low)
            slacks += high is not None
    return x + [0] * slacks


def unreduced(x, lower, upper, friction):
    z, x = [], iter(x)
    for i, (low, high) in enumerate(zip(lower, upper)):
        if friction and friction["friction_of"][i] is not None:
            z.append(next(x) - next(x))
        elif low is None:
            z.append(high - next(x))
        else:
            z.append(low if low == high else low + next(x))
    return z


def handed_over(problem, z):
    """What a solver in z >= 0 answers for z."""
    if "lower" not in problem:
        return z
    return reduced(z, problem["lower"], problem["upper"], {"friction_of": problem.get("friction_of") or [None] * len(z)})


def proof_cases():
    """Bare LCPs with an answer and a proof that there is none: the margin decides whether they are nearly solvable."""
    for share in (1e-9, 0.9e-6, 1.1e-6, 1e-3, 1):
        yield lcp([[0, 0], [1, 1]], [-share, -1]), [0, 1], [1, 0]
        yield lcp([[1, -1], [-1, 1]], [-1, 1 - share]), [1, 0], [1, 1]
        yield lcp([[0, 1e6], [-1e6, 0]], [1, -share]), [0, 0], [0, 1]
        yield lcp([[1, -1], [-1, 1]], [-1, 1 - share]), [1e9 + 1, 1e9], [1, 1]  # passes, whatever the margin
    yield lcp([[0, 1, -1], [-1, 0, 0], [1, 0, 0]], [0, 2, -5]), [3, 1e8, 1e8], [0, 1, 1]  # at most 2 and at least 5


def close(found, expected, tolerance, absolute):
    try:
        expected = float(expected)
    except OverflowError:
        expected = math.inf
    if math.isinf(expected):
        return found is None
    return found is not None and abs(found - expected) <= max(tolerance * abs(expected), absolute)


def check(row, problem, z, velocity, proof):
    expected = second_judge.judge(problem, z, velocity)
    errors, complaints = row["errors"], []
    if proof and problem["kind"] == "contact":
        # Without a proof the program looks for one.
        proofs = [u for u in (proof, [1, -1], [-1, 1]) if second_judge.disproves(problem, u)]
        if bool(proofs) != (row["truth"] in ("unsolvable", "nearly")):
            complaints.append(f"truth {row['truth']}, proofs {proofs}")
    elif proof:
        expected["proof_margin"] = second_judge.proof_margin(problem, proof)
        truth = second_judge.truth_by_proof(expected["proof_margin"])
        if row["truth"] != truth:
            complaints.append(f"truth {row['truth']}, by its margin {truth}")
    for measure in MEASURES:
        # The work is a difference of terms up to 2^60 times as large, in sums of 106 bits.
        tolerance = 1e-12 if measure == "work_gain_j" else 1e-13
        absolute = 2.0**-53 if measure.startswith(("backward_", "returned_")) else 1e-300
        if measure == "violation_m_per_s" and "rows" in problem:
            absolute = 2.0**-100  # of sums of thirds, in 113 bits
        if expected.get(measure) is None:
            continue
        if not close(errors[measure], expected[measure], tolerance, absolute):
            complaints.append(f"{measure} {errors[measure]}, the page says {float(expected[measure])}")
    if problem["kind"] == "contact" and "G" in problem and second_judge.solvable_by_theory(problem):
        if row["truth"] != "solvable":
            complaints.append(f"truth {row['truth']}, by theory solvable")
    if row["verdict"] != second_judge.verdict(row["claim"], expected["passes"], row["truth"]):
        complaints.append(f"verdict {row['verdict']} of claim {row['claim']}, passes: {expected['passes']}")
    if (row["errors"]["worst_row"] is None) != (expected["worst_row"] is None):
        complaints.append(f"worst row {row['errors']['worst_row']}, the page says {expected['worst_row']}")
    if (row["why"] == "") != (row["verdict"] == "solved"):
        complaints.append("a verdict that is not solved needs a reason")
    return complaints


def answered(program, cases, settings):
    """The rows of `solve` for these problems, each with its own answer."""
    with tempfile.TemporaryDirectory() as folder:
        files, given = [], {}
        for number, (problem, z, velocity, proof) in enumerate(cases):
            name = f"case{number}"
            claim = "unsolvable" if proof else ("solved", "iteration_limit")[number % 5 == 4]
            given[name] = {"claim": claim, "z": handed_over(problem, z), **({"velocity": velocity} if velocity else {}),
                           **({"farkas": proof} if proof else {})}
            files.append(os.path.join(folder, name + ".json"))
            with open(files[-1], "w", encoding="utf-8") as file:
                json.dump({"format": "lcpbench-problem", "version": 1, "name": name, **problem}, file)
        answers = os.path.join(folder, "answers")
        with open(answers, "w", encoding="utf-8") as file:
            json.dump(given, file)
        script = os.path.join(HERE, "fixed_answers.py")
        output = subprocess.run([program, "solve", *files, "--format", "json", "--solver",
                                 f"external{{{settings}command={sys.executable} {script} {answers}}}"],
                                capture_output=True, text=True, check=False)
    found = json.loads(output.stdout or "[]")
    if len(found) != len(cases):
        sys.exit(f"{len(found)} rows for {len(cases)} cases\n{output.stderr}")
    return found


def main():
    program = os.path.abspath(sys.argv[1])
    draw = random.Random(20)
    cases = [(problem, z, None, None) for problem, z in [*known_cases(), *random_cases(draw)]]
    cases += [(*case, None) for case in velocity_cases(draw)]
    cases += [(problem, z, None, proof) for problem, z, proof in proof_cases()]
    with_rows = [(problem, z, None, None) for problem, z in [*known_row_cases(), *random_row_cases(draw)]]
    with_rows += [(problem, z, None, proof) for problem, z, proof in row_proof_cases()]
    found = answered(program, cases, "") + answered(program, with_rows, "form=contact,compliance=true,rows=true,")
    cases += with_rows
    failures, verdicts = 0, {}
    for number, (row, (problem, z, velocity, proof)) in enumerate(zip(found, cases)):
        verdicts[row["verdict"]] = verdicts.get(row["verdict"], 0) + 1
        for complaint in check(row, problem, z, velocity, proof):
            failures += 1
            print(f"case {number}: {complaint}\n  {json.dumps(problem)}\n  z = {z}, {velocity}")
    print(f"{len(cases)} cases, {verdicts}, {failures} differences")
    if failures or min(verdicts.get(word, 0) for word in ("solved", "wrong")) < 10:
        sys.exit(1)


main()
