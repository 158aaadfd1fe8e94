"""Problems in rational numbers, for check_certificates.py: what a file says, and nothing that lcpbench made of it."""

import functools
import math
from fractions import Fraction


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
    rows = values if is_matrix else [values]
    require(all(isinstance(x, float) for row in rows for x in row), "an entry of a vector or matrix is no number")
    ratios = [[x.as_integer_ratio() for x in row] for row in rows]
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


def reduced(rows, unknowns):
    """The echelon form of equations: lists of as many coefficients as there are unknowns, then the right-hand side.
    @returns its rank, and the unknowns where these are determined; None for equations that contradict each other"""
    rows, rank = [list(row) for row in rows], 0
    for column in range(unknowns):
        pivot = next((i for i in range(rank, len(rows)) if rows[i][column]), None)
        if pivot is None:
            continue
        rows[rank], rows[pivot] = rows[pivot], rows[rank]
        top = [entry / rows[rank][column] for entry in rows[rank]]
        rows = [top if i == rank else [a - row[column] * b for a, b in zip(row, top)] if row[column] else row
                for i, row in enumerate(rows)]
        rank += 1
    if any(row[unknowns] for row in rows[rank:]):
        return None
    return rank, [row[unknowns] for row in rows[:rank]] if rank == unknowns else None


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

    def nonnegative(self):
        """M by rows, and q, as fractions, of an LCP in unknowns >= 0."""
        return [[Fraction(entry, self.M.denominator) for entry in row] for row in self.M.numerators], self.q.fractions()


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


class BoundedRows:
    """R, bounds, b and compliance; a bound that is None stands for none."""

    FIELDS = "R lower upper b compliance friction_of mu unit names"

    def __init__(self, document, ngc):
        unknown = set(document) - set(self.FIELDS.split())
        require(not unknown, f"rows have no field {', '.join(sorted(unknown))}")
        self.count = len(document["R"][0]) if document["R"] else 0
        self.R = matrix_of(document, "R", ngc, self.count)
        self.load = [-1 if j is None else int(j) for j in document.get("friction_of", [None] * self.count)]
        self.mu = self.numbers(document, "mu")
        self.b = self.numbers(document, "b")
        self.compliance = self.numbers(document, "compliance")
        self.lower, self.upper = self.bounds(document, "lower", -1), self.bounds(document, "upper", 1)
        require(len(self.load) == self.count, "friction_of is not one number for each row")
        require(all(x >= 0 for x in self.mu + self.compliance), "mu or compliance of a row is negative")
        for i, j in enumerate(self.load):
            self.check_row(i, j)

    def numbers(self, document, field):
        given = document.get(field, [0.0] * self.count)
        values = from_doubles([0.0 if x is None and field == "mu" else x for x in given]).fractions()
        require(len(values) == self.count, f"{field} is not one number for each row")
        return values

    def bounds(self, document, field, sign):
        values = document.get(field, [None] * self.count)
        require(len(values) == self.count, f"{field} is not one bound for each row")
        known = [None if x is None or sign * x >= 1e20 else x for x in values]
        require(all(x is None or isinstance(x, float) for x in known), f"{field} has an entry that is no number")
        return [None if x is None else Fraction(x) for x in known]

    def check_row(self, i, j):
        lower, upper = self.lower[i], self.upper[i]
        require((lower or 0) <= 0 <= (upper or 0), f"row {i}: its bounds are not around zero")
        require(lower is None or upper is None or lower < upper, f"row {i}: both of its bounds are zero")
        if j >= 0:
            require(lower is None and upper is None, f"row {i} of friction has other bounds")
            require(j < self.count and self.load[j] < 0 and self.lower[j] == 0, f"row {i}: row {j} bears no friction")

    def velocities(self, u):
        """R'u + b."""
        return [w + b for w, b in zip(transposed_times(self.R, u, self.count).fractions(), self.b)]

    def check(self, f, w):
        """The conditions of all rows."""
        for i, j in enumerate(self.load):
            most = self.mu[i] * f[j] if j >= 0 else None
            lower, upper = (self.lower[i], self.upper[i]) if j < 0 else (-most, most)
            require(lower is None or f[i] >= lower, f"the impulse of row {i} is below its lower bound")
            require(upper is None or f[i] <= upper, f"the impulse of row {i} is above its upper bound")
            require(w[i] <= 0 or f[i] == lower, f"row {i} has w > 0 above its lower bound")
            require(w[i] >= 0 or f[i] == upper, f"row {i} has w < 0 below its upper bound")

    def check_weights(self, u):
        """Of a proof that there is no solution: R'u is then no less than zero in every solution."""
        for i, weight in enumerate(u.numerators):
            if weight:
                bound = self.upper[i] if weight > 0 else self.lower[i]
                require(bound is None and self.load[i] < 0, f"u counts on the velocity of row {i}, which has a bound")
                require(self.compliance[i] == 0, f"u pushes row {i}, which yields")

    def nonnegative(self, M, q):
        """The LCP in unknowns >= 0 from that of z = [.. f_R]: f is a bound plus or minus an unknown, or the
        difference of two, and a slack stands for a second bound, or for the limit of friction."""
        first = len(q) - self.count
        parts, origin, slacks, of_row = [(i, 1) for i in range(first)], [Fraction(0)] * len(q), [], []
        for i, j in enumerate(self.load):
            lower, upper, k = self.lower[i], self.upper[i], len(parts)
            of_row.append(k)
            parts.append((first + i, -1 if lower is None and upper is not None else 1))
            if lower is None and upper is None:
                parts.append((first + i, -1))
                if j >= 0:
                    slacks.append((i, [k, k + 1], Fraction(0)))
            else:
                origin[first + i] = lower if lower is not None else upper
                if lower is not None and upper is not None:
                    slacks.append((i, [k], upper - lower))
        size = len(parts) + len(slacks)
        rows = [[s * t * M[i][j] for j, t in parts] + [Fraction(0)] * len(slacks) for i, s in parts]
        constants = [s * (q[i] + sum(a * x for a, x in zip(M[i], origin) if x)) for i, s in parts]
        for number, (i, own, length) in enumerate(slacks, len(parts)):
            row = [Fraction(0)] * size
            for k in own:
                row[k], rows[k][number] = Fraction(-1), Fraction(1)
            if self.load[i] >= 0:
                row[of_row[self.load[i]]] = self.mu[i]
            rows.append(row)
            constants.append(length)
        return rows, constants


class Contact:
    """v, N, D, mu, edges, bounded rows, and the inertia in one of its three forms."""

    def __init__(self, document):
        self.v = from_doubles(document["v"])
        self.ngc = len(self.v)
        require(len({"D", "edges", "mu"} & set(document)) in (0, 3), "D, edges and mu come together or not at all")
        given = document.get("edges", [0.0] * (len(document["N"][0]) if document["N"] else 0))
        require(all(isinstance(e, float) and e >= 0 and e % 2 == 0 for e in given), "edges has no even number >= 0")
        self.edges = [int(e) for e in given]
        self.nc = len(self.edges)
        self.friction = sum(self.edges)
        self.N = matrix_of(document, "N", self.ngc, self.nc)
        self.D = matrix_of(document, "D", self.ngc, self.friction) if self.friction else Rationals([[]] * self.ngc, 1)
        self.mu = from_doubles(document["mu"]) if "mu" in document else zeros(self.nc)
        self.b = from_doubles(document["b"]) if "b" in document else zeros(self.nc)
        require(len(self.b) == self.nc, "b is not one number for each contact")
        self.read_softness(document)
        require(len(self.mu) == self.nc and is_nonnegative(self.mu), "mu is not one number >= 0 for each contact")
        self.first = [sum(self.edges[:i]) for i in range(self.nc)]
        self.cones = [i for i in range(self.nc) if self.edges[i] > 0]
        self.first_row = self.nc + self.friction + len(self.cones)
        self.rows = BoundedRows(document["rows"], self.ngc) if "rows" in document else None
        self.size = self.first_row + (self.rows.count if self.rows else 0)
        self.check_directions()
        self.read_inertia(document)

    def read_softness(self, document):
        """The compliance matrix R has r_n for a normal, and r_t C_k'C in the row of friction direction k."""
        count = {"compliance_n": self.nc, "compliance_t": self.nc, "offset_t": 2 * self.nc}
        given = {name: from_doubles(document.get(name, [0.0] * length)).fractions() for name, length in count.items()}
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
        require(set(factors) == {"X", "alpha"}, "G_factors has other fields than X and alpha")
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

    def impulse(self, z):
        """C f = N f_N + D f_D + R f_R."""
        f = plus(times(self.N, z.part(0, self.nc)), times(self.D, z.part(self.nc, self.nc + self.friction)))
        return plus(f, times(self.rows.R, z.part(self.first_row, self.size))) if self.rows else f

    def on_contacts(self, u):
        """C'u."""
        return joined(transposed_times(self.N, u, self.nc), transposed_times(self.D, u, self.friction))

    def velocities(self, u):
        """C'u + [b; C'offset_t]: w of the dense rows without slip bounds and compliance; q for u = v."""
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
        w = self.velocities(velocity).fractions()
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
        return w + slack + self.row_complement(entries[self.first_row:], velocity)

    def row_complement(self, f, velocity):
        """w of the bounded rows."""
        if self.rows is None:
            return []
        return [w + r * x for w, r, x in zip(self.rows.velocities(velocity), self.rows.compliance, f)]

    def nonnegative(self):
        """M by rows, and q, as fractions, of an LCP in unknowns >= 0: the velocities that each impulse alone, and each
        lambda, gives."""
        q = self.complement(zeros(self.size), self.v)
        columns = []
        for j in range(self.size):
            z = Rationals([int(i == j) for i in range(self.size)], 1)
            moved = self.moved_by(self.potential_of(self.impulse(z)))
            columns.append([a - b for a, b in zip(self.complement(z, plus(self.v, moved)), q)])
        M = [list(row) for row in zip(*columns)]
        return self.rows.nonnegative(M, q) if self.rows else (M, q)

    def potential_of(self, impulse):
        """p of K p = B f, by elimination."""
        if self.form == "Ginv":
            return times(self.G, impulse)
        units = (Rationals([int(i == j) for i in range(self.potentials)], 1) for j in range(self.potentials))
        columns = [self.stiffness_times(unit).fractions() for unit in units]
        rows = [[column[i] for column in columns] + [b] for i, b in enumerate(self.reduced(impulse).fractions())]
        solved = reduced(rows, self.potentials)
        require(solved is not None and solved[1] is not None, "the inertia is singular")
        return from_fractions(solved[1])


def read_problem(document):
    require(document["format"] == "lcpbench-problem" and document["version"] == 1, "no problem file of version 1")
    kinds = {"lcp": (BareLcp, "M q"),
             "contact": (Contact, "v N D edges mu b G G_factors Ginv compliance_n compliance_t offset_t rows")}
    require(document["kind"] in kinds, "neither a bare LCP nor a contact problem")
    make, fields = kinds[document["kind"]]
    unknown = set(document) - {"format", "version", "name", "kind", *fields.split()}
    require(not unknown, f"the problem of a proof has no field {', '.join(sorted(unknown))}")
    return make(document)
