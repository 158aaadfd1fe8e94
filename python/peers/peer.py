"""What the peers share: the external protocols of lcpbench (docs/reference/external.md), and contacts as arrays."""
import json
import os
import sys
import time

import numpy as np
import scipy.sparse

out = os.fdopen(os.dup(1), "w")
os.dup2(2, 1)  # a library that prints, also while it is imported after this, does not spoil an answer
spent = [0.0]  # seconds of this solve


def timed(call, *arguments, **named):
    """A call of the library. Its time, in which Python reads and writes no numbers, is the detail of an answer that has
    no other."""
    begin = time.perf_counter()
    result = call(*arguments, **named)
    spent[0] += time.perf_counter() - begin
    return result


def serve(load, warm=lambda: None):
    """Answers line by line. load(problem) is timed as set-up. It returns the function solve(start) that answers, or, if
    the problem is refused, the reason as text. start is a guess at z, or None. warm() is called once, before the first
    problem, and not timed."""
    for line in sys.stdin:
        request, reply = json.loads(line), {}
        try:
            if request["verb"] == "problem":
                problem, first, warm = request["problem"], warm, lambda: None
                first()
            elif request["verb"] == "setup":
                solve = load(problem)
            elif request["verb"] == "solve":
                start, spent[0] = np.array(request["start"]) if "start" in request else None, 0.0
                reply = {"claim": "unsupported", "detail": solve} if isinstance(solve, str) else solve(start)
                if not np.all(np.isfinite(reply.get("z", []))):
                    raise ArithmeticError("impulses that are not finite")
                if spent[0]:
                    reply.setdefault("detail", f"reported: {spent[0]:.3e} s")
        except (ArithmeticError, RuntimeError, TypeError, ValueError, np.linalg.LinAlgError) as error:
            failure = {"claim": "numerical_failure", "detail": f"{type(error).__name__}: {error}".splitlines()[0][:200]}
            if request["verb"] == "solve":
                reply = failure
            else:
                solve = lambda _, failure=failure: failure
        print(json.dumps({**reply, "sequence": request["sequence"]}), file=out, flush=True)


def matrix(value, rows):
    """Dense, from a list of rows or from columns as problem files have them."""
    if not isinstance(value, dict):
        array = np.array(value, dtype=float)
        return array if array.ndim == 2 else array.reshape(rows, 0)  # no rows are an empty list
    shape = rows, len(value["starts"]) - 1
    return scipy.sparse.csc_matrix((value["values"], value["rows"], value["starts"]), shape=shape).toarray()


class Contacts:
    """v, N, D, edges, mu, b of a contact problem; its inertia G (None where only its inverse or its factors
    are given) and Ginv, the inverse or pseudo-inverse."""

    def __init__(self, problem):
        self.v = np.array(problem["v"], dtype=float)
        n = len(self.v)
        self.N = matrix(problem["N"], n)
        self.nc = self.N.shape[1]
        self.edges = problem.get("edges", [0] * self.nc)
        self.D = matrix(problem["D"], n) if "D" in problem else np.zeros((n, 0))
        self.mu, self.b = (np.array(problem.get(name, [0] * self.nc), dtype=float) for name in ("mu", "b"))
        self.G = None
        if "G" in problem:
            self.G = matrix(problem["G"], n)
        elif "G_blocks" in problem:
            self.G, at = np.zeros((n, n)), 0
            for block in problem["G_blocks"]:
                self.G[at : at + len(block), at : at + len(block)] = block
                at += len(block)
        if self.G is not None:
            self.Ginv = np.linalg.inv(self.G)
        elif "Ginv" in problem:
            self.Ginv = matrix(problem["Ginv"], n)
        else:
            X = matrix(problem["G_factors"]["X"], n)
            self.Ginv = np.linalg.pinv((X * problem["G_factors"]["alpha"]) @ X.T)
        self.begin = self.nc + np.concatenate([[0], np.cumsum(self.edges)]).astype(int)

    @classmethod
    def of_scene(cls, scene):
        """Of free bodies: six coordinates each, linear before angular. `frames` are normal and tangents of contacts."""
        bodies, contacts = scene["bodies"], scene["contacts"]
        columns, frames = np.zeros((6 * len(bodies), len(contacts), 3)), np.zeros((len(contacts), 3, 3))
        for i, contact in enumerate(contacts):
            normal = np.array(contact["normal"])
            tangent = np.array(contact.get("tangent", [0, 0, 0]))
            frames[i] = normal, tangent, np.cross(normal, tangent)
            for k, sign in ((contact["body_a"], 1), (contact["body_b"], -1)):
                if k >= 0:
                    arm = np.array(contact["point"]) - bodies[k]["position"]
                    columns[6 * k : 6 * k + 6, i] += sign * np.vstack([frames[i].T, np.cross(arm, frames[i]).T])
        edges = [each.get("edges", 0) for each in contacts]
        slides = columns[:, np.array(edges, dtype=int) == 4, 1:]  # other numbers of edges have no place in a scene
        D = np.concatenate([slides, -slides], axis=2).reshape(len(columns), 4 * slides.shape[1])
        zero = np.zeros((3, 3))
        blocks = [np.block([[each["mass"] * np.eye(3), zero], [zero, np.array(each["inertia"])]]) for each in bodies]
        problem = cls(dict(v=[x for each in bodies for x in each["linear_velocity"] + each["angular_velocity"]],
                           N=columns[:, :, 0], D=D, edges=edges, mu=[each.get("mu", 0.0) for each in contacts],
                           b=[each.get("b", 0.0) for each in contacts], G_blocks=blocks))
        problem.frames, problem.scene = frames, scene
        return problem

    def tangents(self, i):
        """Both tangents of a contact, directions 0 and edges / 4, a whole number; zeros without friction."""
        first = self.begin[i] - self.nc
        edges = self.edges[i]
        return self.D[:, [first, first + edges // 4]] if edges else np.zeros((len(self.v), 2))

    def answer(self, normal, along):
        """z of normal impulses (nc) and impulses along both tangents (nc, 2)."""
        f = np.zeros(self.begin[-1])
        f[: self.nc] = normal
        for i, edges in enumerate(self.edges):
            if edges == 0:
                continue
            a, b = along[i]
            turn = 2 * np.pi / edges
            k = int(np.arctan2(b, a) % (2 * np.pi) / turn) % edges  # between direction k and the next
            low, high = k * turn, (k + 1) * turn
            parts = np.linalg.solve([[np.cos(low), np.cos(high)], [np.sin(low), np.sin(high)]], [a, b])
            f[self.begin[i] + np.array([k, (k + 1) % edges])] = np.maximum(parts, 0)
        return self.complete(f)

    def of_engine(self, pushes):
        """The answer of an engine, which tells no failure: (contact, side on which it acts, impulse) for each."""
        impulses = np.zeros((self.nc, 3))
        for i, side, push in pushes:
            impulses[i] += (-1 if side else 1) * self.frames[i] @ push
        return {"claim": "solved", "z": self.answer(np.maximum(impulses[:, 0], 0), impulses[:, 1:])}

    def along(self, z):
        """Impulses of a z, (nc, 3): along the normal and both tangents."""
        impulses = np.zeros((self.nc, 3))
        impulses[:, 0] = z[: self.nc]
        for i, edges in enumerate(self.edges):
            turns = 2 * np.pi / max(edges, 1) * np.arange(edges)
            impulses[i, 1:] = np.array([np.cos(turns), np.sin(turns)]) @ z[self.begin[i] : self.begin[i + 1]]
        return impulses

    def after(self, f):
        """The velocity after the impulses [f_N; f_D], with which a z begins."""
        return self.v + self.Ginv @ (self.N @ f[: self.nc] + self.D @ f[self.nc : self.begin[-1]])

    def balls(self, radius, overlaps):
        """Two balls for each contact that touch at its point, and overlap: (contact, side, body or -1, centre from the
        body's)."""
        for i, contact in enumerate(self.scene["contacts"]):
            for side, (k, sign) in enumerate(((contact["body_a"], 1), (contact["body_b"], -1))):
                at = np.array(contact["point"]) + sign * (radius - overlaps[i] / 2) * self.frames[i, 0]
                yield i, side, k, at - (self.scene["bodies"][k]["position"] if k >= 0 else 0)

    def complete(self, f):
        """z of [f_N; f_D]: the least lambda that makes the rows of friction feasible."""
        slip = self.D.T @ self.after(f)
        bounds = [max(0.0, -slip[a - self.nc : b - self.nc].min()) for a, b in zip(self.begin, self.begin[1:]) if b > a]
        return [*map(float, f), *map(float, bounds)]


def serve_engine(name, version, Engine):
    """Answers line by line as an engine that steps scenes: Engine(scene), its place(...) and its step(...)."""
    for line in sys.stdin:
        question = json.loads(line)
        verb = question.pop("verb")
        if verb == "scene":
            engine = Engine(question)
            answer = dict(engine=name, version=version)
        else:
            answer = engine.step(**question) if verb == "step" else engine.place(**question)
        print(json.dumps(answer), file=out, flush=True)
