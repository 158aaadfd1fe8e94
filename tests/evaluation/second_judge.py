"""The judge of docs/explanation/verdicts.md, written again from that page alone.

It computes in exact fractions, for small dense problems."""
import math
import statistics
from fractions import Fraction

SOLVED_RHO = Fraction(1e-4)
SOLVED_ETA = Fraction(1e-6)
SOLVED_VELOCITY = Fraction(1e-4)
LEAST_SPEED = Fraction(1e-8)
SPEED_SHARE = Fraction(1e-6)
ENERGY_SHARE = Fraction(1e-8)
FLOOR_SHARE = Fraction(0.01)
LEAST_COUPLING = Fraction(1e-9)
INFINITY = math.inf


def exact(values):
    return [Fraction(value) for value in values]


def quotient(value, scale):
    if value == 0:
        return Fraction(0)
    return INFINITY if scale == 0 else value / scale


def middle_of(c, z, lower, upper, w):
    """The middle one of c (z - lower), c (z - upper) and w; a bound that is none is infinite, also where c is 0."""
    return sorted((INFINITY if lower == -INFINITY else c * (z - lower),
                   -INFINITY if upper == INFINITY else c * (z - upper), w))[1]


def bounds_of(values, none):
    return [none if value is None else Fraction(value) for value in values]


def groups(n, related):
    """The classes of 0..n-1 that the relation's pairs join, as lists in the order of their first members."""
    label = list(range(n))
    for a, b in related:
        old, new = max(label[a], label[b]), min(label[a], label[b])
        label = [new if entry == old else entry for entry in label]
    return [[i for i in range(n) if label[i] == first] for first in sorted(set(label))]


class Bare:
    """LCP(q, M), mixed or not. A bound that is none is an infinite float."""

    def __init__(self, problem):
        self.M, self.q = [exact(row) for row in problem["M"]], exact(problem["q"])
        n = len(self.q)

        def bounds(key, none, bare):
            return bounds_of(problem[key], none) if key in problem else [bare] * n

        self.lower, self.upper = bounds("lower", -INFINITY, Fraction(0)), bounds("upper", INFINITY, INFINITY)
        self.friction_of = problem.get("friction_of") or [None] * n
        self.mu = problem.get("mu") or [None] * n
        self.blocks = groups(n, [(i, j) for i in range(n) for j in range(n) if self.M[i][j] != 0])
        self.norms = [sum(map(abs, row)) or Fraction(1) for row in self.M]
        self.floors = self.floors_of_rows()

    def nearest_to_zero(self, j):
        if self.friction_of[j] is not None or self.lower[j] <= 0 <= self.upper[j]:
            return Fraction(0)
        return self.lower[j] if self.lower[j] > 0 else self.upper[j]

    def floors_of_rows(self):
        nearest = [abs(self.nearest_to_zero(j)) for j in range(len(self.q))]
        sizes = [abs(q) + dot(map(abs, row), nearest) for q, row in zip(self.q, self.M)]
        floors = [None] * len(self.q)
        for block in self.blocks:
            largest, share = max(sizes[k] for k in block), max(sizes[k] / self.norms[k] for k in block)
            for i in block:
                floors[i] = min(self.norms[i] * share, largest)
        return floors

    def errors(self, z):
        """eta of each row."""
        for i, row in enumerate(self.M):
            c, w = self.norms[i], self.q[i] + dot(row, z)
            lower, upper = self.lower[i], self.upper[i]
            if self.friction_of[i] is not None:
                upper = abs(Fraction(self.mu[i]) * z[self.friction_of[i]])
                lower = -upper
            middle = middle_of(c, z[i], lower, upper, w)
            terms = abs(self.q[i]) + dot(map(abs, row), map(abs, z))
            yield quotient(abs(middle), max(terms, FLOOR_SHARE * self.floors[i]))


def judge_bare(problem, z):
    eta, row = Fraction(0), None
    for i, error in enumerate(Bare(problem).errors(exact(z))):
        if error > eta:
            eta, row = error, i
    return {"backward_row_norm": eta, "worst_row": row, "passes": eta <= SOLVED_ETA, "criterion": False}


def proof_margin(problem, u):
    """By how much of its own size the bare LCP misses a solution; None if u proves nothing."""
    data, u = Bare(problem), exact(u)
    missing = -dot(data.q, u)
    if min(u) < 0 or missing <= 0 or any(dot(column, u) > 0 for column in zip(*data.M)):
        return None
    return missing / sum(weight * max(abs(q), floor) for weight, q, floor in zip(u, data.q, data.floors))


def disproves(problem, u):
    """Whether u = [u_N; u_R] proves that the contact problem has no solution."""
    data, u = Contact(problem), exact(u)
    rows, nc = data.rows, data.nc
    if len(u) != nc + len(rows.R):
        return False
    u_rows, compliance_n = u[nc:], problem.get("compliance_n") or [0] * nc
    may_push = all(weight == 0 or weight > 0 and compliance_n[c] == 0 for c, weight in enumerate(u[:nc]))
    may_act = all(weight == 0 or rows.friction_of[k] is None and rows.compliance[k] == 0
                  and (rows.upper[k] == INFINITY if weight > 0 else rows.lower[k] == -INFINITY)
                  for k, weight in enumerate(u_rows))
    push = [dot(entries, u) for entries in zip(*data.J[:nc], *rows.R)]
    still = all(dot(column, push) == 0 for column in (data.G if data.factors is None else data.factors))
    return may_push and may_act and still and dot(data.q[:nc] + data.q[data.first_row:], u) < 0


def solvable_by_theory(problem):
    """Of contacts with positive definite G and mu >= 0, or that all yield."""
    data = Contact(problem)
    rows, nc = data.rows, data.nc
    r_n, r_t = problem.get("compliance_n") or [0] * nc, problem.get("compliance_t") or [0] * nc
    offset_t = problem.get("offset_t") or [0] * (2 * nc)

    def row_holds(k):
        of = rows.friction_of[k]
        if rows.b[k] == 0 or rows.compliance[k] > 0:
            return True
        if of is not None:
            return rows.compliance[of] > 0 or rows.upper[of] < INFINITY
        if rows.lower[k] == -INFINITY:
            return rows.upper[k] < INFINITY and rows.b[k] <= 0
        return rows.upper[k] < INFINITY or rows.b[k] >= 0

    contacts_hold = all(r_n[c] > 0 or data.b[c] >= 0 and (r_t[c] > 0 or offset_t[2 * c:2 * c + 2] == [0, 0])
                        for c in range(nc))
    return contacts_hold and all(map(row_holds, range(len(rows.R))))


def truth_by_proof(margin):
    return "unsolvable" if margin > SOLVED_ETA else "nearly"


def solve_exactly(G, right):
    n = len(G)
    rows = [list(G[i]) + [column[i] for column in right] for i in range(n)]
    for k in range(n):
        pivot = next(i for i in range(k, n) if rows[i][k] != 0)
        rows[k], rows[pivot] = rows[pivot], rows[k]
        rows[k] = [entry / rows[k][k] for entry in rows[k]]
        for i in range(n):
            if i != k and rows[i][k] != 0:
                rows[i] = [a - rows[i][k] * b for a, b in zip(rows[i], rows[k])]
    return [[rows[i][n + c] for i in range(n)] for c in range(len(right))]


def product(A, B):
    return [[dot(row, column) for column in zip(*B)] for row in A]


def independent(columns):
    """Those that no combination of the columns before them is."""
    kept, reduced = [], []
    for column in columns:
        rest = list(column)
        for pivot, other in reduced:
            factor = rest[pivot] / other[pivot]
            rest = [a - factor * b for a, b in zip(rest, other)]
        pivot = next((i for i, entry in enumerate(rest) if entry != 0), None)
        if pivot is not None:
            kept.append(column)
            reduced.append((pivot, rest))
    return kept


def factored(problem):
    """G = X diag(alpha) X', and a basis of its range."""
    X, alpha = [exact(row) for row in problem["G_factors"]["X"]], exact(problem["G_factors"]["alpha"])
    weighted = [[entry * weight for entry, weight in zip(row, alpha)] for row in X]
    return product(weighted, list(zip(*X))), independent(list(zip(*X)))


def respond(G, basis, J):
    """G* J, column by column: B (B'G B)^-1 B' with the basis B."""
    inner = product(product(basis, G), list(zip(*basis)))
    right = [[dot(b, column) for b in basis] for column in J]
    return [[dot(row, c) for row in zip(*basis)] for c in solve_exactly(inner, right)]


def dot(a, b):
    return sum((x * y for x, y in zip(a, b)), Fraction(0))


def columns_of(matrix):
    return [exact(column) for column in zip(*matrix)]


class Rows:
    """The bounded rows of a contact problem."""

    def __init__(self, given, ngc):
        self.R = columns_of(given["R"]) if ngc and given else []
        m = len(self.R)
        self.friction_of = given.get("friction_of") or [None] * m
        self.mu = exact(value or 0 for value in given.get("mu") or [0] * m)
        self.lower = bounds_of(given.get("lower") or [None] * m, -INFINITY)
        self.upper = bounds_of(given.get("upper") or [None] * m, INFINITY)
        self.b, self.compliance = exact(given.get("b") or [0] * m), exact(given.get("compliance") or [0] * m)
        self.is_angle = [unit == "rad" for unit in given.get("unit") or ["m"] * m]

    def bounds(self, k, impulses):
        """Of row k, at these impulses of all rows."""
        if self.friction_of[k] is None:
            return self.lower[k], self.upper[k]
        limit = abs(self.mu[k] * impulses[self.friction_of[k]])
        return -limit, limit


class Contact:
    """LCP(q, M) of a contact problem with dense G or with factors, its rows by contact, and its islands.

    The direction of a cone row is zero, so that J has a column for each entry of z = [f_N; f_D; lambda; f_R]."""

    def __init__(self, problem):
        self.v = exact(problem["v"])
        ngc = len(self.v)
        self.factors = [exact(column) for column in zip(*problem["G_factors"]["X"])] if "G_factors" in problem else None
        if self.factors is None:
            self.G = [exact(row) for row in problem["G"]]
        else:
            self.G, basis = factored(problem)
        self.J = columns_of(problem["N"])
        self.nc = len(self.J)
        edges = problem.get("edges") or [0] * self.nc
        mu = exact(problem.get("mu") or [0] * self.nc)
        self.rows = Rows(problem.get("rows") or {}, ngc)
        if sum(edges):
            self.J += columns_of(problem["D"])
        cones = [c for c in range(self.nc) if edges[c] > 0]
        self.cones = range(len(self.J), len(self.J) + len(cones))
        self.first_row = self.cones.stop
        self.J += [[Fraction(0)] * ngc for _ in cones] + self.rows.R
        # A row of friction belongs to the row that bounds it.
        self.contact_of = [*range(self.nc), *(c for c in range(self.nc) for _ in range(edges[c])), *cones,
                           *(self.nc + (k if of is None else of) for k, of in enumerate(self.rows.friction_of))]
        self.responses = solve_exactly(self.G, self.J) if self.factors is None else respond(self.G, basis, self.J)
        n = len(self.J)
        soft = {key: exact(problem.get(key) or [0] * size * self.nc)
                for key, size in (("b", 1), ("compliance_n", 1), ("compliance_t", 1), ("offset_t", 2))}
        # Of 2 or 4 edges: the tangent of each direction, with its sign.
        along = [(c, k % 2 if edges[c] == 4 else 0, 1 if 2 * k < edges[c] else -1)
                 for c in range(self.nc) for k in range(edges[c])]
        self.b = (soft["b"] + [sign * soft["offset_t"][2 * c + tangent] for c, tangent, sign in along]
                  + [Fraction(0)] * len(cones) + self.rows.b)
        self.q = [dot(column, self.v) + b for column, b in zip(self.J, self.b)]
        self.M = [[dot(direction, response) for response in self.responses] for direction in self.J]
        self.moved = [self.M[i][i] for i in range(n)]  # without compliance
        for c in range(self.nc):
            self.M[c][c] += soft["compliance_n"][c]
        for k, compliance in enumerate(self.rows.compliance, self.first_row):
            self.M[k][k] += compliance
        for i, (c, tangent, sign) in enumerate(along, self.nc):
            for j, (other, other_tangent, other_sign) in enumerate(along, self.nc):
                if (c, tangent) == (other, other_tangent):
                    self.M[i][j] += sign * other_sign * soft["compliance_t"][c]
        for cone, c in zip(self.cones, cones):
            self.M[cone][c] = mu[c]
            for i in range(self.nc, self.cones.start):
                if self.contact_of[i] == c:
                    self.M[i][cone] = Fraction(1)
                    self.M[cone][i] = Fraction(-1)
        self.island_of, self.touched = self.coordinate_islands()
        self.levers = [self.lever(i) for i in range(n)]

    def coordinate_islands(self):
        """The island of each coordinate, and of each contact or row the first coordinate that it touches."""
        ngc = len(self.v)
        columns = list(zip(*self.G)) if self.factors is None else self.factors
        pairs = [(a, b) for column in columns for a in range(ngc) for b in range(ngc)
                 if column[a] != 0 and column[b] != 0]
        touched = {}
        for direction, contact in zip(self.J, self.contact_of):
            for a in range(ngc):
                if direction[a] != 0:
                    first = touched.setdefault(contact, a)
                    pairs.append((first, a))
        return {a: number for number, group in enumerate(groups(ngc, pairs)) for a in group}, touched

    def island(self, i):
        """That of row i of M."""
        contact = self.contact_of[i]
        return self.island_of[self.touched[contact]] if contact in self.touched else ("alone", contact)

    def islands(self):
        rows = {}
        for row in range(len(self.J)):
            rows.setdefault(self.island(row), []).append(row)
        return list(rows.values())

    def lever(self, i):
        """What turns the residual of row i into m/s."""
        if i < self.first_row or not self.rows.is_angle[i - self.first_row] or self.moved[i] == 0:
            return Fraction(1)
        contacts = [c for c in range(self.nc) if self.moved[c] > 0]
        along = [k for k in range(self.first_row, len(self.J))
                 if not self.rows.is_angle[k - self.first_row] and self.moved[k] > 0]
        for chosen in ([c for c in contacts if self.M[c][i] ** 2 > LEAST_COUPLING ** 2 * self.moved[c] * self.moved[i]],
                       [c for c in contacts if self.island(c) == self.island(i)],
                       [k for k in along if self.island(k) == self.island(i)]):
            if chosen:
                return Fraction(math.sqrt(statistics.median(self.moved[c] for c in chosen) / self.moved[i]))
        return Fraction(1)

    def scale(self, island):
        """What the residuals of an island are relative to."""
        largest = max([LEAST_SPEED] + [-self.q[i] for i in island if i < self.nc])
        for i in island:
            if i >= self.first_row:
                largest = max(largest, self.residual(i, [Fraction(0)] * len(self.J), self.q[i]))
            count = sum(1 for entry in self.J[i] if entry != 0)
            magnitude = dot(map(abs, self.J[i]), map(abs, self.v))
            rounding = (count + 1) * (Fraction(2) ** -53 * magnitude + Fraction(2) ** -1074)
            if i not in self.cones:
                speed = SPEED_SHARE * abs(dot(self.J[i], self.v))
                largest = max(largest, self.levers[i] * speed, self.levers[i] * rounding / SOLVED_RHO)
        return largest

    def velocity_error(self, returned, z, v_plus):
        """How far a returned velocity is from v+."""
        ngc = len(self.v)
        if len(returned) != ngc:
            return INFINITY
        label, touched = self.island_of, self.touched
        inverse = solve_exactly(self.G, [[Fraction(int(i == j)) for j in range(ngc)] for i in range(ngc)])
        pushes = [sum((abs(J[a] * f) for J, f in zip(self.J, z)), Fraction(0)) for a in range(ngc)]
        change = [abs(after - before) for after, before in zip(v_plus, self.v)]
        inertial = [sum(abs(self.G[a][b]) * change[b] for b in range(ngc)) for a in range(ngc)]
        root = [Fraction(math.sqrt(self.G[a][a])) for a in range(ngc)]
        worst = Fraction(0)
        for a in range(ngc):
            apart = abs(exact(returned)[a] - v_plus[a])
            error = apart / max(LEAST_SPEED, abs(self.v[a]) + abs(v_plus[a] - self.v[a]))
            if error > SOLVED_VELOCITY:
                acting = [i for i in range(len(z)) if z[i] != 0 and i not in self.cones
                          and self.island(i) == label[a]]
                moved = {label[first] for first in touched.values()}
                alike = [b for b in range(ngc) if label[b] == label[a] or not {label[a], label[b]} & moved]
                energy = sum((self.v[b] * self.G[b][c] * self.v[c] for b in alike for c in alike), Fraction(0))
                cancels = Fraction(math.sqrt(energy)) + sum(Fraction(math.sqrt(self.M[i][i])) * abs(z[i]) for i in acting)
                size = Fraction(math.sqrt(inverse[a][a])) * cancels
                solving = len(alike) * Fraction(2) ** -53 * sum(abs(inverse[b][a]) * inertial[b] for b in range(ngc))
                rounding = ((len(acting) + 1) * (Fraction(2) ** -53 * size + Fraction(2) ** -1074)
                            + min(solving,
                                  SOLVED_VELOCITY * max(root[b] * change[b] for b in alike) / root[a]))
                scale = abs(self.v[a]) + sum(abs(inverse[b][a]) * pushes[b] for b in range(ngc))
                kept = ENERGY_SHARE * Fraction(math.sqrt(inverse[a][a] * energy))
                error = apart / max(scale + rounding / SOLVED_VELOCITY, kept, LEAST_SPEED)
            worst = max(worst, error)
        return worst

    def residual(self, i, z, w):
        if i >= self.first_row:
            lower, upper = self.rows.bounds(i - self.first_row, z[self.first_row:])
            return self.levers[i] * abs(middle_of(self.M[i][i], z[i], lower, upper, w))
        if i not in self.cones:
            return abs(min(self.M[i][i] * z[i], w))
        normal = self.contact_of[i]
        return abs(min(z[i], self.M[normal][normal] * w))


def judge_contact(problem, z, velocity):
    """By the pyramid."""
    data, z = Contact(problem), exact(z)
    n = len(data.q)
    w = [data.q[i] + dot(data.M[i], z) for i in range(n)]
    rho, worst, largest = Fraction(0), None, Fraction(0)
    for island in data.islands():
        residual, row = max(((data.residual(i, z, w[i]), -i) for i in island))
        scale = data.scale(island)
        largest = max(largest, residual)
        if quotient(residual, scale) > rho:
            rho, worst = quotient(residual, scale), -row
    v_plus = list(data.v)
    for response, impulse in zip(data.responses, z):
        v_plus = [a + b * impulse for a, b in zip(v_plus, response)]
    change = [a - b for a, b in zip(v_plus, data.v)]
    work = dot([dot(row, change) for row in data.G], [a + b for a, b in zip(v_plus, data.v)]) / 2
    asked = -dot(data.b, z)  # the work that the offset asks for
    violation = max(Fraction(0), -min(w[:data.nc], default=Fraction(0)))
    error = None if velocity is None else data.velocity_error(velocity, z, v_plus)
    return {"velocity_residual_relative": rho, "velocity_residual_m_per_s": largest, "worst_row": worst,
            "returned_velocity_error": error,
            "violation_m_per_s": violation, "work_gain_j": work,
            "passes": rho <= SOLVED_RHO and (error is None or error <= SOLVED_VELOCITY),
            "criterion": violation < Fraction(1e-3) and work - asked < Fraction(1e-3)}


def judge(problem, z, velocity=None):
    """What docs/explanation/verdicts.md finds of a usable z, and the velocity that came with it: the measures, `passes`
    and `criterion`."""
    return judge_bare(problem, z) if problem["kind"] == "lcp" else judge_contact(problem, z, velocity)


def verdict(claim, passes, truth):
    if truth == "nearly" and claim == "unsolvable":
        return "unsolvable"
    if passes and truth != "unsolvable":
        return "solved"
    if claim == "solved":
        return "wrong"
    if truth == "unsolvable":
        return "unsolvable"
    if claim == "unsupported":
        return "refused"
    return "missed" if truth in ("solvable", "nearly") else "open"
