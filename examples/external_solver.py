#!/usr/bin/env python3
"""Lemke's algorithm on a tableau, as an external solver of lcpbench. docs/reference/external.md explains every line."""
import json
import sys


def lemke(M, q):
    """Finds z >= 0 with w = M z + q >= 0 and z'w = 0. Columns: n of w, n of z, the artificial one, the right-hand side."""
    n, artificial = len(q), 2 * len(q)
    if all(entry >= 0 for entry in q):
        return {"claim": "solved", "z": [0.0] * n, "pivots": 0}
    table = [[float(i == j) for j in range(n)] + [-m for m in M[i]] + [-1.0, q[i]] for i in range(n)]
    basis, entering, row = list(range(n)), artificial, q.index(min(q))
    for pivots in range(1, 100 * n):
        table[row] = [entry / table[row][entering] for entry in table[row]]
        for i in range(n):
            if i != row and table[i][entering] != 0:
                table[i] = [a - table[i][entering] * b for a, b in zip(table[i], table[row])]
        leaving, basis[row] = basis[row], entering
        if leaving == artificial:
            value = dict(zip(basis, (max(0.0, line[-1]) for line in table)))
            return {"claim": "solved", "z": [value.get(n + i, 0.0) for i in range(n)], "pivots": pivots}
        entering = leaving + n if leaving < n else leaving - n  # the complement of what left
        blocking = [i for i in range(n) if table[i][entering] > 1e-12]
        if not blocking:
            return {"claim": "unsolvable", "detail": "secondary ray", "pivots": pivots}
        row = min(blocking, key=lambda i: [e / table[i][entering] for e in table[i][-1:] + table[i][:n]])
    return {"claim": "iteration_limit"}


problem = None
for line in sys.stdin:
    request, reply = json.loads(line), {}
    if request["verb"] == "problem":
        problem = request["problem"]
    elif request["verb"] == "solve":
        reply = lemke(problem["M"], problem["q"])
    print(json.dumps({**reply, "sequence": request["sequence"]}), flush=True)
