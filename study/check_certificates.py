#!/usr/bin/env python3
"""Checks certificates of LCPs and contact problems, exactly, and trusts none of the code that made them.

    check_certificates.py FILE...        stores of `lcpbench certify --store`, or files of `--proofs`

Needs Python 3.9 or later and nothing else; shares no code with lcpbench. It is one file, so that a reader who wants to
check it has it all in one place, and can copy it to another machine. Every double is read as the rational number
that it is, every test is an identity or an inequality between integers: there is no tolerance.
docs/explanation/certificates.md says why each test proves what it proves.

Exit codes: 0 every certificate was accepted; 1 one was rejected; 2 a file cannot be read.
"""

import argparse
import collections
import functools
import json
import math
import multiprocessing
import re
import sqlite3
import struct
import sys
import zlib
from fractions import Fraction

PROOFS_OF = {"solution": ("exact_basis", "lp"), "unsolvable": ("farkas", "branching")}


class Rejected(Exception):
    """Why a certificate is not accepted."""


def require(condition, reason):
    if not condition:
        raise Rejected(reason)


# ---------------------------------------------------------------------------------------------- exact numbers


def rounded(number, denominator):
    """The nearest double; None, as JSON has it, beyond the largest."""
    try:
        return number / denominator  # int / int rounds correctly
    except OverflowError:
        return None


class Rationals:
    """A list of rationals, or of rows of them: integers over one positive denominator."""

    def __init__(self, numerators, denominator):
        self.numerators = numerators
        self.denominator = denominator

    def __len__(self):
        return len(self.numerators)

    def part(self, begin, end):
        return Rationals(self.numerators[begin:end], self.denominator)

    def fractions(self):
        return [Fraction(number, self.denominator) for number in self.numerators]

    def rounded(self):
        return [rounded(number, self.denominator) for number in self.numerators]


def from_doubles(values):
    """A vector, or a matrix as a list of rows, of doubles; each is an integer times a power of two."""
    is_matrix = bool(values) and isinstance(values[0], list)
    ratios = [[float(x).as_integer_ratio() for x in row] for row in (values if is_matrix else [values])]
    denominator = max((d for row in ratios for _, d in row), default=1)
    rows = [[n * (denominator // d) for n, d in row] for row in ratios]
    return Rationals(rows if is_matrix else rows[0], denominator)


def times(matrix, x):
    numerators = [sum(a * b for a, b in zip(row, x.numerators) if b) for row in matrix.numerators]
    return Rationals(numerators, matrix.denominator * x.denominator)


def transposed_times(matrix, x, columns):
    numerators = [0] * columns
    for row, factor in zip(matrix.numerators, x.numerators):
        if factor:
            for j, entry in enumerate(row):
                numerators[j] += entry * factor
    return Rationals(numerators, matrix.denominator * x.denominator)


def plus(x, y, sign=1):
    pairs = zip(x.numerators, y.numerators)
    return Rationals([a * y.denominator + sign * b * x.denominator for a, b in pairs], x.denominator * y.denominator)


def entrywise(x, y):
    return Rationals([a * b for a, b in zip(x.numerators, y.numerators)], x.denominator * y.denominator)


def dot(x, y):
    return Fraction(sum(entrywise(x, y).numerators), x.denominator * y.denominator)


def equal(x, y):
    return len(x) == len(y) and not any(plus(x, y, -1).numerators)


def is_zero(x):
    return not any(x.numerators)


def is_nonnegative(x):
    return all(number >= 0 for number in x.numerators)


def zeros(length):
    return Rationals([0] * length, 1)


def joined(x, y):
    return Rationals([a * y.denominator for a in x.numerators] + [b * x.denominator for b in y.numerators],
                     x.denominator * y.denominator)


def is_positive(matrix, strictly):
    """Positive (semi)definite, for a symmetric matrix: elimination of integers in which every division is exact."""
    rows = [list(row) for row in matrix.numerators]
    left, previous = list(range(len(rows))), 1
    while left:
        least = min(rows[i][i] for i in left)
        if least < 0 or (strictly and least == 0):
            return False
        pivot = next((i for i in left if rows[i][i] > 0), None)
        if pivot is None:  # semidefinite with a diagonal of zeros: zero
            return not any(rows[i][j] for i in left for j in left)
        left.remove(pivot)
        top = rows[pivot][pivot]
        for i in left:
            for j in left:
                rows[i][j] = (top * rows[i][j] - rows[i][pivot] * rows[pivot][j]) // previous
        previous = top
    return True


# --------------------------------------------------------------------------------------------------- problems


class BareLcp:
    def __init__(self, document):
        self.size = len(document["q"])
        self.q = from_doubles(document["q"])
        self.M = matrix_of(document, "M", self.size, self.size)

    def complement(self, z):
        return plus(times(self.M, z), self.q)


def directions(edges):
    """Cosine and sine of a contact's friction directions, to multiples of 2^-40; opposite ones exactly opposite."""
    def rounded_to_grid(x):
        return Fraction(round(math.ldexp(x, 40)), 2**40)

    half = []
    for k in range(edges // 2):
        if 4 * k == edges:
            half.append((Fraction(0), Fraction(1)))
        else:
            angle = 2 * math.pi * k / edges
            half.append((rounded_to_grid(math.cos(angle)), rounded_to_grid(math.sin(angle))))
    return half + [(-c, -s) for c, s in half]


def from_fractions(values):
    denominator = math.lcm(*(value.denominator for value in values)) if values else 1
    return Rationals([value.numerator * (denominator // value.denominator) for value in values], denominator)


def matrix_of(document, field, rows, columns):
    values = document[field]
    fits = len(values) == rows and all(len(row) == columns for row in values)
    require(fits, f"{field} has not the size {rows} x {columns}")
    return from_doubles(values) if values else Rationals([], 1)


class Contact:
    """v, N, D, mu, edges and the inertia in one of its three forms."""

    def __init__(self, document):
        self.v = from_doubles(document["v"])
        self.ngc = len(self.v)
        self.edges = [int(e) for e in document["edges"]] if "edges" in document else None
        if self.edges is None:
            self.edges = [0] * (len(document["N"][0]) if document["N"] else 0)
        self.nc = len(self.edges)
        self.friction = sum(self.edges)
        self.N = matrix_of(document, "N", self.ngc, self.nc)
        self.D = matrix_of(document, "D", self.ngc, self.friction) if self.friction else zeros_matrix(self.ngc)
        self.mu = from_doubles(document["mu"]) if "mu" in document else zeros(self.nc)
        self.b = from_doubles(document["b"]) if "b" in document else zeros(self.nc)
        require(len(self.b) == self.nc, "b is not one number for each contact")
        self.read_softness(document)
        require(len(self.mu) == self.nc and is_nonnegative(self.mu), "mu is not one number >= 0 for each contact")
        self.first = [sum(self.edges[:i]) for i in range(self.nc)]
        self.cones = [i for i in range(self.nc) if self.edges[i] > 0]
        self.size = self.nc + self.friction + len(self.cones)
        self.check_directions()
        self.read_inertia(document)

    def read_softness(self, document):
        """Of friction row k the compliance matrix has r_t C_k'C, see direction()."""
        count = {"compliance_n": self.nc, "compliance_t": self.nc, "offset_t": 2 * self.nc}
        given = {name: [Fraction(x) for x in document.get(name, [0] * length)] for name, length in count.items()}
        for name, length in count.items():
            require(len(given[name]) == length, f"{name} does not have {length} entries")
        self.r_n, self.r_t = given["compliance_n"], given["compliance_t"]
        require(all(r >= 0 for r in self.r_n + self.r_t), "a compliance is negative")
        self.is_soft = any(any(values) for values in given.values())
        offset = given["offset_t"]
        along = [c * offset[2 * i] + s * offset[2 * i + 1] for i, e in enumerate(self.edges)
                 for c, s in directions(e)]
        self.offsets = joined(self.b, from_fractions(along)) if any(offset) else joined(self.b, zeros(self.friction))

    def yielding(self, f):
        """R f of the impulses f, as fractions."""
        numbers = f.fractions()
        result = [r * x for r, x in zip(self.r_n, numbers)]
        begin = self.nc
        for r, e in zip(self.r_t, self.edges):
            net = [sum(d[k] * x for d, x in zip(directions(e), numbers[begin:begin + e])) for k in (0, 1)]
            result += [r * (c * net[0] + s * net[1]) for c, s in directions(e)]
            begin += e
        return result

    def check_directions(self):
        for i in self.cones:
            require(self.edges[i] % 2 == 0, f"contact {i} has an odd number of edges")
            half = self.edges[i] // 2
            for t in range(self.first[i], self.first[i] + half):
                require(all(row[t] == -row[t + half] for row in self.D.numerators), f"contact {i}: D is not in pairs")

    def read_inertia(self, document):
        forms = [name for name in ("G", "G_factors", "Ginv") if name in document]
        require(len(forms) == 1, "the inertia is not given in one form")
        self.form = forms[0]
        if self.form == "G_factors":
            self.read_factors(document["G_factors"])
            return
        self.G = matrix_of(document, self.form, self.ngc, self.ngc)
        rows = self.G.numerators
        symmetric = all(rows[i][j] == rows[j][i] for i in range(self.ngc) for j in range(i))
        require(symmetric, f"{self.form} is not symmetric")
        self.potentials = self.ngc

    def read_factors(self, factors):
        """Those of alpha = 0 are left out."""
        alpha = from_doubles(factors["alpha"])
        require(is_nonnegative(alpha), "alpha is negative")
        X = matrix_of(factors, "X", self.ngc, len(alpha))
        kept = [k for k, number in enumerate(alpha.numerators) if number]
        self.alpha = Rationals([alpha.numerators[k] for k in kept], alpha.denominator)
        self.X = Rationals([[row[k] for k in kept] for row in X.numerators], X.denominator)
        self.potentials = len(kept)

    @functools.cached_property
    def has_inertia(self):
        """G is positive definite, or made of positive factors, or the given G* is positive semidefinite."""
        return self.form == "G_factors" or is_positive(self.G, strictly=self.form == "G")

    def impulse(self, f):
        """C f = N f_N + D f_D."""
        return plus(times(self.N, f.part(0, self.nc)), times(self.D, f.part(self.nc, self.nc + self.friction)))

    def on_contacts(self, u):
        """C'u."""
        return joined(transposed_times(self.N, u, self.nc), transposed_times(self.D, u, self.friction))

    def velocities(self, u):
        """C'u + [b; C'offset_t]: what the dense rows have for w without friction's bounds; q for the velocity before."""
        return plus(self.on_contacts(u), self.offsets)

    def reduced(self, impulse):
        """B f from C f: X'C f for factors, else C f."""
        return transposed_times(self.X, impulse, self.potentials) if self.form == "G_factors" else impulse

    def moved_by(self, p):
        """The change of velocity that a potential stands for."""
        return times(self.X, p) if self.form == "G_factors" else p

    def is_potential_of(self, p, impulse):
        """K p = B f; where only G* is given, p = G* C f."""
        if self.form == "Ginv":
            return equal(p, times(self.G, impulse))
        return equal(self.stiffness_times(p), self.reduced(impulse))

    def stiffness_times(self, p):
        """K p."""
        if self.form == "G":
            return times(self.G, p)
        gram_p = transposed_times(self.X, times(self.X, p), self.potentials)
        return transposed_times(self.X, times(self.X, entrywise(self.alpha, gram_p)), self.potentials)

    def in_null_space(self, impulse):
        """G* C u = 0, which is C u in the null space of G."""
        if self.form == "Ginv":
            return is_zero(times(self.G, impulse))
        return is_zero(self.reduced(impulse))

    def complement(self, z, velocity):
        """w of the dense rows and of the cone rows, from the velocity after the impact."""
        return self.rows(z, self.velocities(velocity))

    def rows(self, z, velocities):
        """The same from what the dense rows have without the bounds of friction in z."""
        w = velocities.fractions()
        entries = z.fractions()
        if self.is_soft:
            w = [a + b for a, b in zip(w, self.yielding(z.part(0, len(w))))]
        slack = []
        for lam, i in enumerate(self.cones):
            bound = entries[self.nc + self.friction + lam]
            for t in range(self.nc + self.first[i], self.nc + self.first[i] + self.edges[i]):
                w[t] += bound
            pushed = sum(entries[self.nc + self.first[i] + t] for t in range(self.edges[i]))
            slack.append(Fraction(self.mu.numerators[i], self.mu.denominator) * entries[i] - pushed)
        return w + slack


def zeros_matrix(rows):
    return Rationals([[] for _ in range(rows)], 1)


def read_problem(document):
    require(document["format"] == "lcpbench-problem" and document["version"] == 1, "no problem file of version 1")
    kinds = {"lcp": BareLcp, "contact": Contact}
    require(document["kind"] in kinds, "neither a bare LCP nor a contact problem")
    return kinds[document["kind"]](document)


# ------------------------------------------------------------------------------------------------ certificates


def exact_vector(document, field, length):
    given = document[field]
    if given is None:
        require(length == 0, f"{field} is missing")
        return zeros(0)
    texts = [given["denominator"], *given["numerators"]]
    require(all(re.fullmatch(r"-?[0-9]+", text) for text in texts), f"{field} is not made of integers")
    denominator, *numerators = [int(text) for text in texts]
    require(denominator > 0, f"{field} has no positive denominator")
    require(len(numerators) == length, f"{field} has {len(numerators)} entries, expected {length}")
    return Rationals(numerators, denominator)


def check_rounded(document, field, exact):
    given = document[field]
    require((given or []) == exact.rounded(), f"{field} is not its exact counterpart rounded")


def check_complementary(z, w):
    require(is_nonnegative(z), "z has a negative entry")
    require(all(entry >= 0 for entry in w), "w has a negative entry")
    require(all(a == 0 or b == 0 for a, b in zip(z.numerators, w)), "z and w are both positive in some entry")


def check_contact_solution(problem, z, potential):
    """@returns the velocity after the impact."""
    impulse = problem.impulse(z.part(0, problem.nc + problem.friction))
    require(problem.is_potential_of(potential, impulse), "the potential does not belong to the impulses")
    velocity = plus(problem.v, problem.moved_by(potential))
    check_complementary(z, problem.complement(z, velocity))
    return velocity


def check_other_velocity(document, problem, velocity):
    z = exact_vector(document, "exact_other_z", problem.size)
    other = check_contact_solution(problem, z, exact_vector(document, "exact_other_potential", problem.potentials))
    require(not equal(velocity, other), "the other solution has the same velocity")


def check_solution(document, problem):
    z = exact_vector(document, "exact_z", problem.size)
    check_rounded(document, "z", z)
    unique = document["velocity_unique"]
    if isinstance(problem, BareLcp):
        check_complementary(z, problem.complement(z).fractions())
        require(unique is None and document["velocity"] is None, "a bare LCP has no velocity")
        return
    require(problem.form != "G" or problem.has_inertia, "G is not positive definite")
    velocity = check_contact_solution(problem, z, exact_vector(document, "exact_potential", problem.potentials))
    require(equal(velocity, exact_vector(document, "exact_velocity", problem.ngc)), "another velocity belongs to z")
    check_rounded(document, "velocity", velocity)
    if unique is True:
        require(problem.friction == 0 or is_zero(problem.mu), "nothing says that friction leaves one velocity only")
        require(problem.has_inertia, "the inertia is not positive semidefinite")
    elif unique is False:
        check_other_velocity(document, problem, velocity)
    else:
        require(unique is None, "velocity_unique is neither true nor false nor null")


def check_farkas(document, problem):
    if isinstance(problem, BareLcp):
        y = exact_vector(document, "exact_farkas", problem.size)
        columns = transposed_times(problem.M, y, problem.size)
        require(is_nonnegative(y), "y has a negative entry")
        require(all(entry <= 0 for entry in columns.numerators), "M'y has a positive entry")
        require(dot(problem.q, y) < 0, "q'y is not negative")
        return
    u = exact_vector(document, "exact_farkas", problem.nc + problem.friction)
    require(is_nonnegative(u), "u has a negative entry")
    require(is_zero(u.part(problem.nc, len(u))), "u has a friction part")
    impulse = problem.impulse(u)
    require(problem.in_null_space(impulse), "N u is not in the null space of G")
    require(not any(r * x for r, x in zip(problem.r_n, u.numerators)), "u pushes a contact that yields")
    require(dot(problem.velocities(problem.v), u) < 0, "(N'v + b)'u is not negative")


def check_lp(document, problem):
    require(isinstance(problem, Contact), "only contact problems are proven solvable in this way")
    require(problem.has_inertia, "the inertia is not positive semidefinite")
    d = exact_vector(document, "exact_farkas", problem.potentials)
    shift = times(problem.G, d) if problem.form == "Ginv" else problem.moved_by(d)
    w = problem.velocities(plus(problem.v, shift)).fractions()
    for i in range(problem.nc):
        if problem.r_n[i] > 0:
            continue  # it has no impulse where nothing yields
        begin = problem.nc + problem.first[i]
        slip = max((-w[t] for t in range(begin, begin + problem.edges[i]) if problem.r_t[i] == 0), default=0)
        require(w[i] >= Fraction(problem.mu.numerators[i], problem.mu.denominator) * slip,
                f"contact {i} is not covered by the shifted velocity")


class Transposed:
    """M'y and q'y of the LCP w = q + M z, times positive denominators, for y given as pairs of row and integer."""

    def __init__(self, problem):
        self.problem = problem
        if isinstance(problem, BareLcp):
            return
        require(problem.form != "G" or problem.has_inertia, "G is not positive definite")
        dense = problem.nc + problem.friction
        units = [Rationals([int(i == j) for i in range(dense)], 1) for j in range(dense)]
        self.moved = []  # the change of velocity by each unit impulse
        for p in potentials(problem, [problem.impulse(unit) for unit in units]):
            self.moved.append(problem.moved_by(p))
        common = math.lcm(*(column.denominator for column in self.moved))
        self.moved = [[number * (common // column.denominator) for number in column.numerators]
                      for column in self.moved]
        self.common = common
        self.lambda_of = [lam for lam, i in enumerate(problem.cones) for _ in range(problem.edges[i])]

    def gain(self, y):
        q = self.problem.q if isinstance(self.problem, BareLcp) else self.problem.velocities(self.problem.v)
        return sum(q.numerators[i] * value for i, value in y if i < len(q))

    def columns(self, y):
        problem = self.problem
        if isinstance(problem, BareLcp):
            sums = [0] * problem.size
            for i, value in y:
                sums = [a + b * value for a, b in zip(sums, problem.M.numerators[i])]
            return sums
        # M is symmetric but for mu and the signs of the cone rows.
        dense = problem.nc + problem.friction
        velocity = [0] * problem.ngc
        for i, value in y:
            if i < dense:
                velocity = [a + b * value for a, b in zip(velocity, self.moved[i])]
        w = problem.on_contacts(Rationals(velocity, self.common))
        sums, scale = list(w.numerators) + [0] * len(problem.cones), w.denominator
        mu, unit = problem.mu.numerators, problem.mu.denominator
        sums = [number * unit for number in sums]
        if problem.is_soft:
            own = dict(y)
            softness = problem.yielding(Rationals([own.get(i, 0) for i in range(dense)], 1))
            sums = [a + scale * unit * b for a, b in zip(sums, softness)] + sums[dense:]
        for i, value in y:
            if i >= dense:
                contact = problem.cones[i - dense]
                sums[contact] += mu[contact] * value * scale
                begin = problem.nc + problem.first[contact]
                for t in range(begin, begin + problem.edges[contact]):
                    sums[t] -= value * scale * unit
            elif i >= problem.nc:
                sums[dense + self.lambda_of[i - problem.nc]] += value * scale * unit
        return sums


def check_leaf(transposed, node, w_is_zero, z_is_zero):
    require(len(node) % 2 == 0, "a leaf has a row without a multiplier")
    y = list(zip((index_below(row, transposed.problem.size) for row in node[::2]), map(integer, node[1::2])))
    require(all(value >= 0 or i in w_is_zero for i, value in y), "a leaf has a negative multiplier")
    require(transposed.gain(y) < 0, "a leaf proves nothing: q'y is not negative")
    columns = transposed.columns(y)
    require(all(entry <= 0 or j in z_is_zero for j, entry in enumerate(columns)), "a leaf has M'y positive")


def integer(text):
    require(isinstance(text, str) and re.fullmatch(r"-?[0-9]+", text), "a multiplier is no integer")
    return int(text)


def index_below(number, size):
    require(isinstance(number, float) and number.is_integer() and 0 <= number < size, "a row is none of the problem's")
    return int(number)


def check_branching(document, problem):
    """In every leaf y'w = q'y + (M'y)'z, where the left is not negative and the right is: no z lies in its cones."""
    transposed = Transposed(problem)
    imposed = [(frozenset(), frozenset())]  # what the nodes to come impose: rows with w = 0, rows with z = 0
    require(document["branches"], "branches is missing")
    for node in document["branches"]:
        require(imposed, "there are more nodes than branches")
        w_is_zero, z_is_zero = imposed.pop()
        if isinstance(node, list):
            check_leaf(transposed, node, w_is_zero, z_is_zero)
        else:
            row = index_below(node, problem.size)
            imposed += [(w_is_zero, z_is_zero | {row}), (w_is_zero | {row}, z_is_zero)]
    require(not imposed, "a branch is missing")


def potentials(problem, impulses):
    """A potential of each impulse: K p = B f, by elimination with free entries 0."""
    if problem.form == "Ginv":
        return [times(problem.G, impulse) for impulse in impulses]
    size = problem.potentials
    units = [Rationals([int(i == j) for i in range(size)], 1) for j in range(size)]
    columns = [problem.stiffness_times(unit).fractions() for unit in units]
    columns += [problem.reduced(impulse).fractions() for impulse in impulses]
    work = [[column[i] for column in columns] for i in range(size)]
    pivots = []
    for k in range(size):
        row = next((i for i in range(len(pivots), size) if work[i][k]), None)
        if row is None:
            continue
        top = len(pivots)
        work[top], work[row] = work[row], work[top]
        work[top] = [entry / work[top][k] for entry in work[top]]
        for i in range(size):
            if i != top and work[i][k]:
                work[i] = [a - work[i][k] * b for a, b in zip(work[i], work[top])]
        pivots.append(k)
    require(not any(any(row[size:]) for row in work[len(pivots):]), "an impulse has no potential")
    found = []
    for j in range(size, size + len(impulses)):
        p = [Fraction(0)] * size
        for i, k in enumerate(pivots):
            p[k] = work[i][j]
        denominator = math.lcm(*(entry.denominator for entry in p))
        found.append(Rationals([int(entry * denominator) for entry in p], denominator))
    return found


def check(document):
    """@throws Rejected"""
    require(document["format"] == "lcpbench-proof" and document["version"] == 1, "no proof of version 1")
    kind, proof = document["certificate"], document["proof"]
    require(proof in PROOFS_OF.get(kind, ()), f"'{proof}' is no proof of '{kind}'")
    problem = read_problem(document["problem"])
    if proof == "exact_basis":
        check_solution(document, problem)
    elif proof == "farkas":
        check_farkas(document, problem)
    elif proof == "lp":
        check_lp(document, problem)
    else:
        check_branching(document, problem)


# ------------------------------------------------------------------------------------------- files and stores


def refuse_constant(name):
    raise ValueError(f"{name} is no number")


def parse(text):
    # Every number is a double: "123456789012345680" stands for the double nearest to it.
    return json.loads(text, parse_int=float, parse_constant=refuse_constant)


Item = collections.namedtuple("Item", "name text stored")


def decoded_vector(blob):
    """A vector of a store: length, then index and bits of every entry that is not +0, little-endian."""
    (length,) = struct.unpack_from("<I", blob)
    vector = [0.0] * length
    for index, value in struct.iter_unpack("<Id", blob[4:]):
        vector[index] = value
    return vector


def check_stored(document, stored):
    """The table of certificates says what the proof shows, of the problem that it stands beside."""
    for field in ("certificate", "proof"):
        require(document[field] == stored[field], f"the table says {field} '{stored[field]}'")
    unique = {None: None, 0: False, 1: True}[stored["velocity_unique"]]
    require(unique is document["velocity_unique"], "the table has another velocity_unique")
    velocity = decoded_vector(stored["velocity"]) if stored["velocity"] is not None else []
    require(velocity == (document["velocity"] or []), "the table has another velocity")
    if not stored["set_name"].startswith("file:"):
        names = [stored["name"]] + [stored["set_name"]] * (stored["trial"] == 0)  # one of a kind: the set's
        require(document["problem"]["name"] in names, "the proof is of another problem")
    size = read_problem(document["problem"]).size
    require(size == stored["n"], f"the table has a problem of {stored['n']} unknowns, the proof one of {size}")


def verdict(item):
    """@returns (what it is, "" or why it is rejected)."""
    title = "unreadable"
    try:
        text = item.text
        if isinstance(text, bytes):
            require(text, "its proof is missing")
            text = zlib.decompress(text).decode()
        document = parse(text)
        title = f"{document['certificate']}, {document['proof']}"
        if item.stored is not None:
            check_stored(document, item.stored)
        check(document)
    except Rejected as reason:
        return title, str(reason)
    except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError, struct.error, zlib.error) as error:
        return title, f"malformed: {error!r}"
    return title, ""


QUERY = """
SELECT s.name || ' seed ' || p.seed || ' trial ' || p.trial AS name, s.name AS set_name, p.seed, p.trial, p.n,
       c.certificate, c.proof, c.velocity_unique, v.data AS velocity, d.document
FROM problems p JOIN sets s ON s.id = p.set_id
LEFT JOIN certificates c ON c.problem_id = p.id LEFT JOIN proofs d ON d.problem_id = p.id
LEFT JOIN vectors v ON v.id = c.velocity
WHERE c.problem_id IS NOT NULL OR d.problem_id IS NOT NULL ORDER BY s.name, p.seed, p.trial"""


def items_of_store(path):
    database = sqlite3.connect(f"file:{path}?mode=ro", uri=True)
    database.row_factory = sqlite3.Row
    for row in database.execute(QUERY):
        stored = dict(row)
        seed = stored["seed"] % 2**64  # SQLite's integers have a sign
        stored["name"] = f"{stored['set_name']} seed {seed} trial {stored['trial']}"
        if stored["certificate"] == "open" and stored["document"] is None:
            yield Item(stored["name"], None, None)
        else:
            yield Item(stored["name"], stored.pop("document") or b"", stored)


def items_of_proofs(path):
    with open(path, encoding="utf-8") as file:
        for number, line in enumerate(file, 1):
            yield Item(f"{path} line {number}", line, None)


def items(path):
    with open(path, "rb") as file:
        is_store = file.read(15) == b"SQLite format 3"
    return items_of_store(path) if is_store else items_of_proofs(path)


def judged(item):
    return item.name, *(("open", "") if item.text is None else verdict(item))


def unlimited_digits():
    if hasattr(sys, "set_int_max_str_digits"):  # Python 3.11 refuses integers of more than 4300 digits unless told
        sys.set_int_max_str_digits(0)


def all_judged(path, options):
    if options.jobs <= 1:
        yield from map(judged, items(path))
        return
    with multiprocessing.Pool(options.jobs, initializer=unlimited_digits) as pool:
        yield from pool.imap(judged, items(path), chunksize=8)


def main():
    unlimited_digits()
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n", maxsplit=1)[0])
    parser.add_argument("files", nargs="+", metavar="FILE", help="a store, or a file of proofs")
    parser.add_argument("--jobs", type=int, default=1, help="processes (default 1)")
    options = parser.parse_args()
    accepted, rejected = collections.Counter(), collections.Counter()
    for path in options.files:
        try:
            for name, title, reason in all_judged(path, options):
                (rejected if reason else accepted)[title] += 1
                if reason:
                    print(f"REJECTED {name}: {title}: {reason}")
        except (OSError, UnicodeDecodeError, sqlite3.Error) as error:
            print(f"check_certificates: {path}: {error}", file=sys.stderr)
            return 2
    open_ones = accepted.pop("open", 0)
    for title in sorted(set(accepted) | set(rejected)):
        print(f"{title}: {accepted[title]} accepted, {rejected[title]} rejected")
    if open_ones:
        print(f"open: {open_ones}, nothing to check")
    print(f"{sum(accepted.values())} accepted, {sum(rejected.values())} rejected")
    return 1 if rejected else 0


if __name__ == "__main__":
    sys.exit(main())
