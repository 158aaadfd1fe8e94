"""The judge of docs/explanation/verdicts.md, written again from that page alone.

It computes in exact fractions, for small dense problems."""
import math
from fractions import Fraction

SOLVED_RHO = Fraction(1e-4)
SOLVED_ETA = Fraction(1e-6)
SOLVED_VELOCITY = Fraction(1e-4)
INFINITY = math.inf


def exact(values):
    return [Fraction(value) for value in values]


def quotient(value, scale):
    if value == 0:
        return Fraction(0)
    return INFINITY if scale == 0 else value / scale


def groups(n, related):
    """The classes of 0..n-1 that the relation's pairs join, as lists in the order of their first members."""
    label = list(range(n))
    for a, b in related:
        old, new = max(label[a], label[b]), min(label[a], label[b])
        label = [new if entry == old else entry for entry in label]
    return [[i for i in range(n) if label[i] == first] for first in sorted(set(label))]


def backward_error(M, q, z, block):
    """eta of one block, and the first row where it is taken; None if it is zero."""
    largest = max((abs(z[i]) for i in block), default=Fraction(0))
    worst, worst_row = Fraction(0), None
    for i in block:
        c = sum(abs(M[i][j]) for j in block) or Fraction(1)
        w = q[i] + sum(M[i][j] * z[j] for j in block)
        error = quotient(abs(min(c * z[i], w)), abs(q[i]) + c * largest)
        if error > worst:
            worst, worst_row = error, i
    return worst, worst_row


def judge_bare(problem, z):
    M, q, z = [exact(row) for row in problem["M"]], exact(problem["q"]), exact(z)
    n = len(q)
    blocks = groups(n, [(i, j) for i in range(n) for j in range(n) if M[i][j] != 0])
    eta, row = max((backward_error(M, q, z, block) for block in blocks), key=lambda pair: pair[0])
    return {"backward_row_norm": eta, "worst_row": row, "passes": eta <= SOLVED_ETA, "criterion": False}


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


class Contact:
    """LCP(q, M) of a contact problem with dense G or with factors, its rows by contact, and its islands."""

    def __init__(self, problem):
        self.v = exact(problem["v"])
        self.factors = [exact(column) for column in zip(*problem["G_factors"]["X"])] if "G_factors" in problem else None
        if self.factors is None:
            self.G = [exact(row) for row in problem["G"]]
        else:
            self.G, basis = factored(problem)
        self.J = columns_of(problem["N"])
        self.nc = len(self.J)
        edges = problem.get("edges") or [0] * self.nc
        mu = exact(problem.get("mu") or [0] * self.nc)
        self.contact_of = list(range(self.nc)) + [c for c in range(self.nc) for _ in range(edges[c])]
        if sum(edges):
            self.J += columns_of(problem["D"])
        self.cones = [c for c in range(self.nc) if edges[c] > 0]
        self.responses = solve_exactly(self.G, self.J) if self.factors is None else respond(self.G, basis, self.J)
        impulses = len(self.J)
        n = impulses + len(self.cones)
        self.impulses = impulses
        self.b = exact(problem.get("b") or [0] * self.nc) + [Fraction(0)] * (impulses - self.nc)
        self.q = [dot(column, self.v) + b for column, b in zip(self.J, self.b)] + [Fraction(0)] * len(self.cones)
        self.M = [[Fraction(0)] * n for _ in range(n)]
        for i in range(impulses):
            for j in range(impulses):
                self.M[i][j] = dot(self.J[i], self.responses[j])
        for k, c in enumerate(self.cones):
            self.M[impulses + k][c] = mu[c]
            for i in range(self.nc, impulses):
                if self.contact_of[i] == c:
                    self.M[i][impulses + k] = Fraction(1)
                    self.M[impulses + k][i] = Fraction(-1)
        self.contact_of += self.cones

    def coordinate_islands(self):
        """The island of each coordinate, and of each contact the first coordinate that it touches."""
        ngc = len(self.v)
        columns = list(zip(*self.G)) if self.factors is None else self.factors
        pairs = [(a, b) for column in columns for a in range(ngc) for b in range(ngc)
                 if column[a] != 0 and column[b] != 0]
        touched = {}
        for i in range(self.impulses):
            for a in range(ngc):
                if self.J[i][a] != 0:
                    first = touched.setdefault(self.contact_of[i], a)
                    pairs.append((first, a))
        return {a: number for number, group in enumerate(groups(ngc, pairs)) for a in group}, touched

    def islands(self):
        label, touched = self.coordinate_islands()
        rows = {}
        for row, contact in enumerate(self.contact_of):
            key = label[touched[contact]] if contact in touched else ("alone", contact)
            rows.setdefault(key, []).append(row)
        return list(rows.values())

    def floor(self, i):
        if i >= self.impulses:
            return Fraction(0)
        count = sum(1 for entry in self.J[i] if entry != 0)
        magnitude = dot([abs(entry) for entry in self.J[i]], [abs(x) for x in self.v]) + abs(self.b[i])
        count += 1 if self.b[i] != 0 else 0
        return (count + 1) * (Fraction(2) ** -53 * magnitude + Fraction(2) ** -1074)

    def velocity_error(self, returned, z, v_plus):
        """How far a returned velocity is from v+."""
        ngc = len(self.v)
        if len(returned) != ngc:
            return INFINITY
        label, touched = self.coordinate_islands()
        inverse = solve_exactly(self.G, [[Fraction(int(i == j)) for j in range(ngc)] for i in range(ngc)])
        pushes = [sum((abs(J[a] * f) for J, f in zip(self.J, z)), Fraction(0)) for a in range(ngc)]
        change = [abs(after - before) for after, before in zip(v_plus, self.v)]
        inertial = [sum(abs(self.G[a][b]) * change[b] for b in range(ngc)) for a in range(ngc)]
        root = [Fraction(math.sqrt(self.G[a][a])) for a in range(ngc)]
        worst = Fraction(0)
        for a in range(ngc):
            apart = abs(exact(returned)[a] - v_plus[a])
            error = quotient(apart, abs(self.v[a]) + abs(v_plus[a] - self.v[a]))
            if error > SOLVED_VELOCITY:
                acting = [i for i in range(self.impulses) if z[i] != 0 and self.contact_of[i] in touched
                          and label[touched[self.contact_of[i]]] == label[a]]
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
                error = quotient(apart, scale + rounding / SOLVED_VELOCITY)
            worst = max(worst, error)
        return worst

    def residual(self, i, z, w):
        if i < self.impulses:
            return abs(min(self.M[i][i] * z[i], w[i]))
        normal = self.contact_of[i]
        return abs(min(z[i], self.M[normal][normal] * w[i]))


def judge_contact(problem, z, velocity):
    data, z = Contact(problem), exact(z)
    n = len(data.q)
    w = [data.q[i] + dot(data.M[i], z) for i in range(n)]
    rho, worst, largest = Fraction(0), None, Fraction(0)
    for island in data.islands():
        residual, row = max(((data.residual(i, z, w), -i) for i in island))
        scale = max(max(abs(data.q[i]) for i in island), max(data.floor(i) for i in island) / SOLVED_RHO)
        largest = max(largest, residual)
        if quotient(residual, scale) > rho:
            rho, worst = quotient(residual, scale), -row
    v_plus = list(data.v)
    for response, impulse in zip(data.responses, z):
        v_plus = [a + b * impulse for a, b in zip(v_plus, response)]
    change = [a - b for a, b in zip(v_plus, data.v)]
    work = dot([dot(row, change) for row in data.G], [a + b for a, b in zip(v_plus, data.v)]) / 2
    asked = -dot(data.b, z)  # the work that the offset asks for
    violation = max(Fraction(0), -min(w[:data.nc]))
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
