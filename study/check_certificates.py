#!/usr/bin/env python3
"""Checks certificates of LCPs and contact problems, exactly, and trusts none of the code that made them.

    check_certificates.py FILE...        stores of `lcpbench certify --store`, or files of `--proofs`

Needs Python 3.9 or later and nothing else; shares no code with lcpbench. It is this file and exact_problems.py beside
it, so that a reader who wants to check it has it all in one place, and can copy it to another machine. Every double is
read as the rational number that it is, every test is an identity or an inequality between integers: there is no
tolerance, but for the rounding of the column proof_margin of a store.
docs/explanation/certificates.md says why each test proves what it proves.

Exit codes: 0 every certificate was accepted; 1 one was rejected; 2 a file cannot be read.
"""

import argparse
import collections
import itertools
import json
import math
import multiprocessing
import pathlib
import re
import sqlite3
import struct
import sys
import zlib
from fractions import Fraction

from exact_problems import (BareLcp, Contact, Rationals, Rejected, dot, equal, is_nonnegative, is_positive, is_zero,
                            plus, read_problem, reduced, require, rounded, times, transposed_times, zeros)

PROOFS_OF = {"solution": ("exact_basis", "lp"), "unsolvable": ("farkas", "every_basis")}
MOST_UNKNOWNS = 16  # of problems whose every basis is tried: 2^16 of them take minutes


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
    require(problem.is_potential_of(potential, problem.impulse(z)), "the potential does not belong to the impulses")
    velocity = plus(problem.v, problem.moved_by(potential))
    w, first = problem.complement(z, velocity), problem.first_row
    check_complementary(z.part(0, first), w[:first])
    if problem.rows:
        problem.rows.check(z.part(first, problem.size).fractions(), w[first:])
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
        has_friction = not is_zero(problem.mu) or (problem.rows and any(problem.rows.mu))
        require(not has_friction, "nothing says that friction leaves one velocity only")
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
    normals, others = farkas_vector(document, problem)
    require(is_nonnegative(normals), "u has a negative entry")
    require(problem.rows or is_zero(others), "u has a friction part")
    impulse = times(problem.N, normals)
    if problem.rows:
        problem.rows.check_weights(others)
        impulse = plus(impulse, times(problem.rows.R, others))
    require(problem.in_null_space(impulse), "N u, with R u of bounded rows, is not in the null space of G")
    require(not any(r * x for r, x in zip(problem.r_n, normals.numerators)), "u pushes a contact that yields")
    require(weighted_velocity(problem, normals, others) < 0, "(N'v + b)'u is not negative")


def farkas_vector(document, problem):
    """The weights of the contacts, and those of the bounded rows; without such rows, of friction."""
    others = problem.rows.count if problem.rows else problem.friction
    u = exact_vector(document, "exact_farkas", problem.nc + others)
    return u.part(0, problem.nc), u.part(problem.nc, len(u))


def weighted_velocity(problem, normals, others):
    """u'w of every solution, (N'v + b)'u + (R'v + b)'u."""
    sum_of_normals = dot(problem.velocities(problem.v).part(0, problem.nc), normals)
    if not problem.rows:
        return sum_of_normals
    return sum_of_normals + sum(w * x for w, x in zip(problem.rows.velocities(problem.v), others.fractions()))


def check_every_basis(problem):
    """An LCP with a solution has one that is a vertex: with B its support, the columns B are independent in rows that
    have w = 0, those of B among them. So for each B the rows of B are completed in every way to as many as B determines."""
    M, q = problem.nonnegative()
    require(len(q) <= MOST_UNKNOWNS, "there are too many bases to try them again")
    unknowns = range(len(q))
    for size in range(len(q) + 1):
        for support in itertools.combinations(unknowns, size):
            equations = [[M[i][j] for j in support] + [-q[i]] for i in unknowns]
            of_support = reduced([equations[i] for i in support], size)
            if of_support is None:
                continue
            missing = size - of_support[0]
            if missing and reduced([row[:size] + [Fraction(0)] for row in equations], size)[0] < size:
                continue
            for more in itertools.combinations([i for i in unknowns if i not in support], missing):
                found = reduced([equations[i] for i in (*support, *more)], size)
                if found is None or found[1] is None:
                    continue
                z = found[1]
                w = [q[i] + sum(M[i][j] * x for j, x in zip(support, z)) for i in unknowns]
                require(min(z, default=0) < 0 or min(w) < 0, f"the basis {list(support)} gives a solution")


def check_lp(document, problem):
    is_known = isinstance(problem, Contact) and not problem.rows
    require(is_known, "only contact problems without bounded rows are proven solvable in this way")
    # Every shift of the velocity is in the range of a given G* only if that is definite.
    definite = problem.form == "G_factors" or is_positive(problem.G, strictly=True)
    require(definite, "the inertia, or the given inverse, is not positive definite")
    d = exact_vector(document, "exact_farkas", problem.potentials)
    w = problem.velocities(plus(problem.v, problem.moved_by(d))).fractions()
    for i in range(problem.nc):
        if problem.r_n[i] > 0:
            continue  # it has no impulse where nothing yields
        begin = problem.nc + problem.first[i]
        # Where friction yields, impulses of at most 4 edges that do not cancel in pairs make it yield.
        yields = problem.r_t[i] > 0 and problem.edges[i] <= 4
        slip = max((-w[t] for t in range(begin, begin + problem.edges[i]) if not yields), default=0)
        require(w[i] >= Fraction(problem.mu.numerators[i], problem.mu.denominator) * slip,
                f"contact {i} is not covered by the shifted velocity")


def check(document):
    """@throws Rejected"""
    require(document["format"] == "lcpbench-proof" and document["version"] == 1, "no proof of version 1")
    kind, proof = document["certificate"], document["proof"]
    require(proof != "branching", "proofs by branching, of earlier versions, are no longer checked")
    require(proof in PROOFS_OF.get(kind, ()), f"'{proof}' is no proof of '{kind}'")
    problem = read_problem(document["problem"])
    if proof == "exact_basis":
        check_solution(document, problem)
    elif proof == "every_basis":
        check_every_basis(problem)
    elif proof == "farkas":
        check_farkas(document, problem)
    else:
        check_lp(document, problem)


# ------------------------------------------------------------------------------------------- files and stores


def refuse_constant(name):
    raise ValueError(f"{name} is no number")


def fields_once(pairs):
    document = dict(pairs)
    require(len(document) == len(pairs), "a field is given twice")
    return document


def parse(text):
    # Every number is a double: "123456789012345680" stands for the double nearest to it.
    return json.loads(text, parse_int=float, parse_constant=refuse_constant, object_pairs_hook=fields_once)


# text: the proof, of a store deflated, None: left open; stored: the row of the store, None: of a file of proofs
Item = collections.namedtuple("Item", "name text stored")


def decoded_vector(blob):
    """A vector of a store: length, then index and bits of every entry that is not +0, little-endian."""
    (length,) = struct.unpack_from("<I", blob)
    vector = [0.0] * length
    for index, value in struct.iter_unpack("<Id", blob[4:]):
        vector[index] = value
    return vector


def least_violation(document, problem):
    """By which any impulses violate some contact [m/s], rounded down; None where the proof does not say."""
    if document["proof"] != "farkas" or isinstance(problem, BareLcp):
        return None
    normals, others = farkas_vector(document, problem)
    size = Fraction(sum(normals.numerators), normals.denominator)
    if problem.rows:
        size += Fraction(sum(map(abs, others.numerators)), others.denominator)
    least = -weighted_velocity(problem, normals, others) / size
    nearest = rounded(least.numerator, least.denominator)
    if nearest is None:
        return sys.float_info.max
    return math.nextafter(nearest, 0.0) if least < Fraction(nearest) else nearest


def islands(M):
    """The number of each row's island: rows i and j are in one where M_ij or M_ji is not zero."""
    number = list(range(len(M)))

    def first(i):
        while number[i] != i:
            number[i] = number[number[i]]
            i = number[i]
        return i

    for i, row in enumerate(M):
        for j, entry in enumerate(row):
            if entry:
                number[first(i)] = first(j)
    return [first(i) for i in range(len(M))]


def floors(problem):
    """F_i = min(c_i max(|q_k| / c_k), max |q_k|) over the rows k of the island of row i, c_i the sum of |M_ij|."""
    sizes = [abs(q) for q in problem.q.fractions()]
    sums = [Fraction(sum(map(abs, row)), problem.M.denominator) or Fraction(1) for row in problem.M.numerators]
    number = islands(problem.M.numerators)
    shares, largest = collections.defaultdict(Fraction), collections.defaultdict(Fraction)
    for island, size, total in zip(number, sizes, sums):
        shares[island] = max(shares[island], size / total)
        largest[island] = max(largest[island], size)
    return [min(total * shares[island], largest[island]) for island, total in zip(number, sums)]


def proof_margin(document, problem):
    """By how much of its own size a bare LCP misses a solution; None where the proof does not say."""
    if document["proof"] != "farkas" or not isinstance(problem, BareLcp):
        return None
    u = exact_vector(document, "exact_farkas", problem.size).fractions()
    q = problem.q.fractions()
    size = sum(weight * max(abs(entry), floor) for weight, entry, floor in zip(u, q, floors(problem)))
    require(size > 0, "the proof has no margin")
    return -sum(weight * entry for weight, entry in zip(u, q)) / size


def is_margin(stored, exact):
    """The floors and the quotient are rounded to doubles, by 2^-53 and, towards zero, by 2^-52 of the margin."""
    if exact is None or stored is None:
        return stored is exact
    return abs(Fraction(stored) - exact) < exact / 2**51 + Fraction(1, 2**1074)


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
    problem = read_problem(document["problem"])
    require(problem.size == stored["n"],
            f"the table has a problem of {stored['n']} unknowns, the proof one of {problem.size}")
    require(stored["least_violation"] == least_violation(document, problem), "the table has another least_violation")
    require(is_margin(stored["proof_margin"], proof_margin(document, problem)), "the table has another proof_margin")


def verdict(item):
    """@returns (kind of certificate and proof, "" or why it is rejected)."""
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
    except (ArithmeticError, AttributeError, LookupError, RecursionError, TypeError, ValueError, struct.error,
            zlib.error) as error:
        return title, f"malformed: {error!r}"
    return title, ""


QUERY = """
SELECT s.name || ' seed ' || p.seed || ' trial ' || p.trial AS name, s.name AS set_name, p.seed, p.trial, p.n,
       c.certificate, c.proof, c.velocity_unique, c.least_violation_m_per_s AS least_violation,
       c.proof_margin, v.data AS velocity, d.document
FROM problems p JOIN sets s ON s.id = p.set_id
LEFT JOIN certificates c ON c.problem_id = p.id LEFT JOIN proofs d ON d.problem_id = p.id
LEFT JOIN vectors v ON v.id = c.velocity
WHERE c.problem_id IS NOT NULL OR d.problem_id IS NOT NULL ORDER BY s.name, p.seed, p.trial"""


def items_of_store(path):
    database = sqlite3.connect(f"{pathlib.Path(path).absolute().as_uri()}?mode=ro", uri=True)
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
    """@returns the item's name with its verdict; one that was left open is accepted, as "open"."""
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
