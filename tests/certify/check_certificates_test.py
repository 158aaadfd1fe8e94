"""The checker of certificates accepts what was proven and rejects what was changed, in every way that a proof can be.

usage: check_certificates_test.py CHECKER LCPBENCH
"""

import contextlib
import copy
import importlib.util
import json
import os
import math
import pathlib
import shutil
import sqlite3
import subprocess
import sys
import tempfile

SETS = ("paper/monotone/exp1", "paper/monotone/exp2", "paper/monotone/exp3", "paper/copositive/exp1{nc_max=4}",
        "paper/copositive/exp3{nc_max=10}", "planted/definite", "planted/definite{form=lcp}",
        "hard/contact/stack", "hard/ray/infeasible", "hard/cycling/kostreva")
TRIALS = 12

failures = []


def expect(condition, what):
    if not condition:
        failures.append(what)


def load(path):
    spec = importlib.util.spec_from_file_location("checker", path)
    module = importlib.util.module_from_spec(spec)
    sys.modules["checker"] = module
    sys.path.insert(0, os.path.dirname(os.path.abspath(path)))  # as Python does when it runs the file
    spec.loader.exec_module(module)
    return module


def run(*command):
    return subprocess.run([str(part) for part in command], capture_output=True, text=True, check=False)


def make_store(lcpbench, folder):
    """A store with certificates, and its proofs."""
    store, proofs = folder / "s.db", folder / "proofs.jsonl"
    sets = [argument for name in SETS for argument in ("--set", name)]
    solved = run(lcpbench, "run", *sets, "--solver", "lemke", "--trials", TRIALS, "--store", store)
    expect(solved.returncode == 0, solved.stderr)
    certified = run(lcpbench, "certify", "--store", store, "--every", 1, "--other-velocity", "--proofs", proofs)
    expect(certified.returncode == 0, certified.stderr + certified.stdout)
    return store, [json.loads(line) for line in proofs.read_text().splitlines()]


# --------------------------------------------------------------------------------------------- changed documents


def next_number(x):
    return math.nextafter(x, math.inf)


def first_nonzero(numerators):
    return next((i for i, number in enumerate(numerators) if int(number)), 0)


def add_one(vector, entries):
    at = first_nonzero(vector["numerators"][:entries])
    vector["numerators"][at] = str(int(vector["numerators"][at]) + 1)


def change_sign(vector):
    at = first_nonzero(vector["numerators"])
    vector["numerators"][at] = str(-int(vector["numerators"][at]))


def fixed_entries(document, name):
    """How many entries leave no room: a slip bound of a contact that carries nothing may be any large enough number."""
    bounds = sum(edges > 0 for edges in document["problem"].get("edges", []))
    length = len(document[name]["numerators"])
    return length - bounds if name.endswith("_z") else length


def vectors_of(document):
    names = [name for name in document if name.startswith("exact_") and document[name]]
    if document["proof"] == "lp":
        names = []  # an inequality with room to spare: a proof changed a little is another proof
    return names


def changed_documents(document, others):
    """Pairs of what was changed, and a document that proves nothing any more."""
    def changed(edit):
        result = copy.deepcopy(document)
        edit(result)
        return result

    for name in vectors_of(document):
        yield f"{name}: one numerator", changed(lambda d: add_one(d[name], fixed_entries(document, name)))
        if any(int(number) for number in document[name]["numerators"]):
            yield f"{name}: one sign", changed(lambda d: change_sign(d[name]))
            if name != "exact_farkas":  # of which every positive multiple proves the same
                yield f"{name}: the denominator", changed(
                    lambda d: d[name].update(denominator=str(2 * int(d[name]["denominator"]))))
        yield f"{name}: a negative denominator", changed(
            lambda d: d[name].update(denominator="-" + d[name]["denominator"]))
        yield f"{name}: no integer", changed(lambda d: d[name]["numerators"].__setitem__(0, "1.0"))
        yield f"{name}: one entry less", changed(lambda d: d[name]["numerators"].pop())
        yield f"{name}: one entry more", changed(lambda d: d[name]["numerators"].append("0"))
        yield f"{name}: missing", changed(lambda d: d.update({name: None}))
    if document["proof"] == "lp":
        yield "lp: pushed the other way", changed(lambda d: d["exact_farkas"].update(
            numerators=[str(-1000 * int(x)) for x in d["exact_farkas"]["numerators"]]))
        yield "lp: one entry less", changed(lambda d: d["exact_farkas"]["numerators"].pop())
    for name in ("z", "velocity"):
        if document[name]:
            yield f"{name}: one bit", changed(lambda d: d[name].__setitem__(0, next_number(d[name][0])))
            yield f"{name}: missing", changed(lambda d: d.update({name: None}))
    other_kind = "unsolvable" if document["certificate"] == "solution" else "solution"
    yield "the other kind", changed(lambda d: d.update(certificate=other_kind))
    for proof in {"exact_basis", "farkas"} - {document["proof"]}:
        kind = "solution" if proof == "exact_basis" else "unsolvable"
        yield f"kind and proof of {proof}", changed(lambda d: d.update(certificate=kind, proof=proof))
    yield "open", changed(lambda d: d.update(certificate="open", proof="none"))
    yield "another version", changed(lambda d: d.update(version=2))
    for other in others:
        yield f"the problem of {other['problem']['name']}", changed(lambda d: d.update(problem=other["problem"]))
    if document["velocity_unique"] is not False and document["problem"]["kind"] == "contact":
        if document["proof"] == "exact_basis":
            yield "two velocities claimed", changed(lambda d: d.update(velocity_unique=False))
    if document["proof"] == "exact_basis" and any(document["problem"].get("mu", [])):
        yield "one velocity claimed", changed(lambda d: d.update(velocity_unique=True))
    if document["problem"]["kind"] == "contact" and document["proof"] == "exact_basis":
        yield "v by one ulp", changed(lambda d: d["problem"]["v"].__setitem__(0, next_number(d["problem"]["v"][0])))
    if document["problem"]["kind"] == "contact":
        yield "G_blocks beside", changed(lambda d: d["problem"].update(G_blocks=[]))
        yield "an entry that is a text", changed(lambda d: d["problem"]["v"].__setitem__(0, str(d["problem"]["v"][0])))
    if any(document["problem"].get("edges", [])):
        yield "edges 4.7", changed(lambda d: d["problem"].update(edges=[e + 0.7 for e in d["problem"]["edges"]]))
        yield "D and mu without edges", changed(lambda d: d["problem"].pop("edges"))
    if "G" in document["problem"]:
        corner = document["problem"]["G"][0][1]
        yield "G not symmetric", changed(lambda d: d["problem"]["G"][0].__setitem__(1, next_number(corner)))
        yield "G not definite", changed(lambda d: d["problem"]["G"][0].__setitem__(0, -1.0))


def test_documents(checker, documents):
    def reason(document):
        return checker.verdict(checker.Item("test", json.dumps(document), None))[1]

    kinds = {(d["certificate"], d["proof"], d["problem"]["kind"]) for d in documents}
    for kind in (("solution", "exact_basis", "contact"), ("solution", "exact_basis", "lcp"), ("unsolvable", "farkas", "contact")):
        expect(kind in kinds, f"no certificate of the kind {kind}: the test has to see one")
    tried = 0
    for number, document in enumerate(documents):
        expect(reason(document) == "", f"{document['problem']['name']}: rejected: {reason(document)}")
        others = [documents[number - 1], documents[(number + TRIALS) % len(documents)]]
        for what, changed in changed_documents(document, others):
            tried += 1
            expect(reason(changed) != "", f"{document['problem']['name']}: accepted with a change: {what}")
    twice = json.dumps(documents[0]).replace('"kind":', '"kind": "lcp", "kind":')
    expect(checker.verdict(checker.Item("test", twice, None))[1] == "a field is given twice", "a field given twice")
    print(f"{len(documents)} proofs, {tried} changed ones, kinds {sorted(kinds)}")


def small_lcp(M, q, kind, proof, farkas=None):
    exact = {"denominator": "1", "numerators": [str(x) for x in farkas]} if farkas else None
    return {"format": "lcpbench-proof", "version": 1, "certificate": kind, "proof": proof, "z": None, "velocity": None,
            "velocity_unique": None, "exact_z": None, "exact_potential": None, "exact_velocity": None,
            "exact_farkas": exact, "exact_other_z": None, "exact_other_potential": None,
            "problem": {"format": "lcpbench-problem", "version": 1, "name": "small", "kind": "lcp", "M": M, "q": q}}


def test_small_proofs(checker):
    """Bare LCPs whose truth can be seen on paper."""
    def reason(document):
        return checker.verdict(checker.Item("test", json.dumps(document), None))[1]

    expect(reason(small_lcp([[-1.0]], [-1.0], "unsolvable", "farkas", [1])) == "", "y = 1 proves it")
    expect(reason(small_lcp([[1.0]], [-1.0], "unsolvable", "farkas", [1])) != "", "y = 1 proves nothing here")
    expect(reason(small_lcp([[-1.0]], [-1.0], "unsolvable", "farkas", [0])) != "", "y = 0 proves nothing")
    branching = {**small_lcp([[-1.0]], [-1.0], "unsolvable", "branching"), "branches": [[0, "1"]]}
    expect(reason(branching) == "proofs by branching, of earlier versions, are no longer checked", reason(branching))
    nested = checker.verdict(checker.Item("test", "[" * 100000, None))[1]
    expect(nested.startswith("malformed: "), f"nested too deep: {nested}")


def test_every_basis(checker):
    """That no basis gives a solution has no certificate but the trying: a false claim of it must be refuted by trying."""
    def reason(M, q):
        return checker.verdict(checker.Item("test", json.dumps(small_lcp(M, q, "unsolvable", "every_basis")), None))[1]

    expect(reason([[2.0, 0.0], [1.0, 0.0]], [-2.0, -2.0]) == "", "z_0 would have to be 1 and at least 2")
    expect(reason([[2.0, 0.0], [1.0, 0.0]], [-2.0, -1.0]) == "the basis [0] gives a solution", "z = (1, 0)")
    expect(reason([[1.0]], [1.0]) == "the basis [] gives a solution", "z = 0")
    # M_BB is singular at each solution z = (1, 0) and beyond: w_1 = z_0 - 1 alone tells where the vertex is.
    expect(reason([[0.0, 0.0], [1.0, 0.0]], [0.0, -1.0]) == "the basis [0] gives a solution", "a singular basis")
    expect(reason([[0.0, 0.0], [1.0, 0.0]], [-1.0, -1.0]) == "", "w_0 = -1")
    many = checker.MOST_UNKNOWNS + 1
    expect(reason([[0.0] * many] * many, [-1.0] * many).startswith("there are too many bases"), "no end of bases")


def test_margins(checker):
    """Of proofs whose margins can be seen on paper."""
    def margin(M, q, farkas):
        document = small_lcp(M, q, "unsolvable", "farkas", farkas)
        return checker.proof_margin(document, checker.read_problem(document["problem"]))

    expect(margin([[-1.0]], [-1.0], [3]) == 1, "the whole of q is missed")
    # The rows are one island, of which F_0 = min(1 * 1/2, 1): c_0 is 1, as row 0 is zero.
    expect(margin([[0.0, 0.0], [1.0, 1.0]], [-2.0**-30, -1.0], [1, 0]) == 2.0**-29, "half of the largest q / c")
    expect(margin([[0.0, 0.0], [0.0, 1.0]], [-2.0**-30, -1.0], [1, 0]) == 1, "an island of its own")
    expect(margin([[-8.0, 0.0], [8.0, 2.0]], [-2.0**-30, -1.0], [1, 0]) == 1.25 * 2.0**-30, "F_0 = 8 / 10")
    third = checker.Fraction(1, 3)
    for stored, holds in ((1 / 3, True), (math.nextafter(1 / 3, 0), True), (1 / 3 * (1 + 1e-15), False), (None, False)):
        expect(checker.is_margin(stored, third) is holds, f"margin {stored} of 1/3")


def test_offsets(checker):
    """A box between two walls, whose offsets ask it to leave both: each proof holds for b = (-1, 1/2) or (-1/2, 1/2)."""
    def reason(b, kind, proof, inertia=("G", [[1, 0], [0, 1]]), **vectors):
        document = {**small_lcp([], [], kind, proof), **vectors}
        document["problem"] = {"format": "lcpbench-problem", "version": 1, "name": "walls", "kind": "contact",
                               "v": [0, 0], "N": [[1, -1], [0, 0]], "b": b, inertia[0]: inertia[1]}
        return checker.verdict(checker.Item("test", json.dumps(document), None))[1]

    def halves(*numerators):
        return {"denominator": "2", "numerators": [str(number) for number in numerators]}

    moved = {"exact_z": halves(1, 0), "exact_potential": halves(1, 0), "exact_velocity": halves(1, 0),
             "z": [0.5, 0.0], "velocity": [0.5, 0.0], "velocity_unique": True}
    proofs = {("unsolvable", "farkas"): {"exact_farkas": halves(2, 2)},
              ("solution", "lp"): {"exact_farkas": halves(1, 0)}, ("solution", "exact_basis"): moved}
    for (kind, proof), vectors in proofs.items():
        of_walls, of_corridor = reason([-1, 0.5], kind, proof, **vectors), reason([-0.5, 0.5], kind, proof, **vectors)
        right, wrong = (of_walls, of_corridor) if kind == "unsolvable" else (of_corridor, of_walls)
        expect(right == "", f"offset, {proof}: {right}")
        expect(wrong != "" and "malformed" not in wrong, f"offset, {proof}: accepted for another b ({wrong})")
    given = reason([-0.5, 0.5], "solution", "lp", ("Ginv", [[4, 0], [0, 4]]), exact_farkas=halves(1, 0))
    expect(given == "", f"lp, where G* is given: {given}")
    given = reason([-0.5, 0.5], "solution", "lp", ("Ginv", [[0, 0], [0, 4]]), exact_farkas=halves(1, 0))
    expect("not positive definite" in given, f"lp, where G* cannot shift the velocity: {given}")
    expect("for each contact" in reason([1], "unsolvable", "farkas", exact_farkas=halves(2, 2)), "b of another length")


# ------------------------------------------------------------------------------------------------ changed stores


STORE_CHANGES = {
    "proofs exchanged": "UPDATE proofs SET document = (SELECT document FROM proofs p WHERE p.problem_id = "
                        "(SELECT MAX(problem_id) FROM proofs)) WHERE problem_id = (SELECT MIN(problem_id) FROM proofs)",
    "a proof missing": "DELETE FROM proofs WHERE problem_id = (SELECT MIN(problem_id) FROM proofs)",
    "a certificate missing": "DELETE FROM certificates WHERE problem_id = (SELECT MIN(problem_id) FROM proofs)",
    "a certificate left open": "UPDATE certificates SET certificate = 'open', proof = 'none' "
                               "WHERE problem_id = (SELECT MIN(problem_id) FROM proofs)",
    "damaged bytes": "UPDATE proofs SET document = substr(document, 1, 100) "
                     "WHERE problem_id = (SELECT MIN(problem_id) FROM proofs)",
    "another kind in the table": "UPDATE certificates SET certificate = CASE certificate WHEN 'solution' "
                                 "THEN 'unsolvable' ELSE 'solution' END "
                                 "WHERE problem_id = (SELECT MIN(problem_id) FROM proofs)",
    "another velocity in the table": "UPDATE certificates SET velocity = (SELECT MIN(velocity) FROM certificates) "
                                     "WHERE problem_id = (SELECT problem_id FROM certificates ORDER BY velocity DESC)",
    "another number of velocities": "UPDATE certificates SET velocity_unique = NULL WHERE velocity_unique = 1",
    "another violation in the table": "UPDATE certificates SET least_violation_m_per_s = least_violation_m_per_s / 2 "
                                      "WHERE least_violation_m_per_s IS NOT NULL",
    "another margin in the table": "UPDATE certificates SET proof_margin = proof_margin * (1 + 1e-15) "
                                   "WHERE proof_margin IS NOT NULL",
    "no margin in the table": "UPDATE certificates SET proof_margin = NULL WHERE proof_margin IS NOT NULL",
    "a margin of contacts": "UPDATE certificates SET proof_margin = 0.5 WHERE least_violation_m_per_s IS NOT NULL",
    "another size in the table": "UPDATE problems SET n = n + 1 WHERE id = (SELECT MIN(problem_id) FROM proofs)",
}


def test_compliance(checker, lcpbench, folder):
    """Of proofs about soft contacts with 2 to 8 edges: as they are, and with another compliance or offset."""
    rows = [[1, 0.5], [-0.25, 1], [0.5, -1]]
    half = [[[1], [0], [0.5]], [[1, 0.75, 0, -0.75], [0, 0.75, 1, 0.75], [0, 0, 0, 0]]]
    D = [side[i] + [-x for x in side[i]] for side in half for i in range(3)]
    problem = {"format": "lcpbench-problem", "version": 1, "name": "soft", "kind": "contact", "v": [-2, -2, 1],
               "N": rows, "D": [D[i] + D[i + 3] for i in range(3)], "edges": [2, 8], "mu": [0.5, 0.25],
               "G_factors": {"X": [[1], [0.5], [-1]], "alpha": [2]}, "compliance_n": [0.1, 0.3],
               "compliance_t": [0.7, 0.2], "offset_t": [0.25, 0, 0.125, -0.3]}
    file, proofs = folder / "soft.json", folder / "soft.jsonl"
    file.write_text(json.dumps(problem))
    certified = run(lcpbench, "certify", file, "--proofs", proofs)
    expect(certified.returncode == 0, certified.stderr)
    document = json.loads(proofs.read_text())

    def reason(changed):
        return checker.verdict(checker.Item("soft", json.dumps(changed), None))[1]

    expect(document["proof"] == "exact_basis", f"soft contacts: {document['proof']}")
    expect(reason(document) == "", f"soft contacts: {reason(document)}")
    for field, at in (("compliance_n", 0), ("compliance_n", 1), ("compliance_t", 1), ("offset_t", 2), ("offset_t", 3)):
        changed = copy.deepcopy(document)
        changed["problem"][field][at] *= 2
        expect(reason(changed) != "", f"soft contacts: another {field}[{at}] is accepted")


def test_six_soft_edges(checker):
    """No solution: friction stops whatever leaves the contact, and its impulses neither cancel in pairs nor yield."""
    document = {**small_lcp([], [], "solution", "lp"), "exact_farkas": {"denominator": "1", "numerators": ["1"]}}
    document["problem"] = {"format": "lcpbench-problem", "version": 1, "name": "soft", "kind": "contact", "v": [0],
                           "N": [[1]], "D": [[-1, 0, 0, 1, 0, 0]], "edges": [6], "mu": [3], "b": [-1],
                           "compliance_t": [1], "G": [[1]]}
    reason = checker.verdict(checker.Item("test", json.dumps(document), None))[1]
    expect("is not covered" in reason, f"lp, six soft edges: {reason}")


def test_stores(checker, path, store, proofs):
    accepted = run(sys.executable, path, store, "--jobs", 2)
    expect(accepted.returncode == 0, accepted.stdout + accepted.stderr)
    expect(accepted.stdout.endswith(f"\n{len(proofs)} accepted, 0 rejected\n"), accepted.stdout)
    for what, sql in STORE_CHANGES.items():
        changed = store.with_name("changed?%41.db")  # a URI would take these for its own
        shutil.copy(store, changed)
        database = sqlite3.connect(changed)
        expect(database.execute(sql).rowcount > 0, f"{what}: nothing was changed")
        database.commit()
        database.close()
        result = run(sys.executable, path, changed)
        expect(result.returncode == 1, f"{what}: exit code {result.returncode}: {result.stdout}{result.stderr}")
        expect("REJECTED " in result.stdout, f"{what}: {result.stdout}")
    older = run(sys.executable, path, store.with_name("none.db"))
    expect(older.returncode == 2 and older.stderr.startswith("check_certificates: "), older.stderr)


def test_rounded_violations(checker, path, lcpbench, folder):
    """Of a store whose least violations are no doubles: some are to be rounded down from the nearest one."""
    walls, store = folder / "walls", folder / "walls.db"
    walls.mkdir()
    for trial in range(TRIALS):
        problem = {"format": "lcpbench-problem", "version": 1, "name": "walls", "kind": "contact", "v": [0, 0],
                   "N": [[1, -1], [0, 0]], "b": [-3, 0.1 * (trial + 1)], "G": [[1, 0], [0, 1]]}
        (walls / f"{trial:02}.json").write_text(json.dumps(problem))
    solved = run(lcpbench, "run", "--set", f"file:{walls}", "--solver", "lemke", "--store", store)
    certified = run(lcpbench, "certify", "--store", store, "--every", 1)
    expect(solved.returncode == certified.returncode == 0, solved.stderr + certified.stderr)
    with contextlib.closing(sqlite3.connect(store)) as database:
        stored = [least for (least,) in database.execute("SELECT least_violation_m_per_s FROM certificates")]
    exact = [(3 - checker.Fraction(0.1 * (trial + 1))) / 2 for trial in range(TRIALS)]  # of u = (1, 1)
    down = [x for x in exact if float(x) > x and math.nextafter(float(x), 0) in stored]
    expect(len(stored) == TRIALS and down, f"walls: no violation of {stored} is rounded down")
    checked = run(sys.executable, path, store)
    expect(checked.stdout.endswith(f"\n{TRIALS} accepted, 0 rejected\n"), checked.stdout + checked.stderr)


def main():
    path, lcpbench = sys.argv[1:]
    checker = load(path)
    checker.unlimited_digits()
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        store, documents = make_store(lcpbench, folder)
        test_documents(checker, documents)
        test_small_proofs(checker)
        test_every_basis(checker)
        test_margins(checker)
        test_offsets(checker)
        test_compliance(checker, lcpbench, folder)
        test_six_soft_edges(checker)
        test_stores(checker, path, store, documents)
        test_rounded_violations(checker, path, lcpbench, folder)
    for failure in failures[:50]:
        print("FAILED:", failure)
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
