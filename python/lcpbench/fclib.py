"""Problems of Siconos' Friction Contact Library as files (FCLIB, HDF5), both ways. Needs `h5py` and scipy.

    python -m lcpbench.fclib walk.scenes --out FOLDER           writes each step that FCLIB has as FOLDER/walk-120.hdf5
    python -m lcpbench.fclib a.hdf5 b.hdf5 --out both.scenes    makes each file a step, numbered from 0

    global:  M v = H r + G l + f,  u = H'v + w,  G'v + b = 0     G = M, v = M^-1 f, N and tangents from columns of H,
                                                                 w = (b, offset_t); rows without bounds: R = G, b
    local:   u = W r + V l + q,  V'r + R l + s = 0               G^-1 = (W V; V' R), v = (q, s), N, tangents and R of rows
                                                                 from columns of the identity

The friction disc of FCLIB becomes a pyramid of four edges along the file's two tangents; in the plane there are two.
FCLIB has no units: those of equality constraints become "m".
"""

from __future__ import annotations

import os
import sys
from collections import Counter
from typing import Any

import numpy as np

from . import _native
from ._files import Recorder, Scenes, Step, _path
from ._native import InputError
from ._problem import Problem
from ._solve import Answer, _problem

__all__ = ["load", "save"]

_MOST = 1 << 26  # numbers of a dataset
_ROUNDING = 1e-10  # of the largest entry: by more the triangles of a matrix differ only if it is not symmetric


def _h5py() -> Any:
    try:
        import h5py
    except ImportError as error:
        raise InputError(f"lcpbench.fclib: needs h5py (pip install h5py): {error}") from None
    return h5py


class _File:
    """An opened file. Nothing of another file is read in its name: its author would learn what stands there."""

    def __init__(self, name: str) -> None:
        self._h5py, self.name = _h5py(), name
        try:
            self._file = self._h5py.File(name, "r")
        except OSError:
            raise InputError(f"{name}: cannot be opened as an HDF5 file") from None

    def __enter__(self) -> _File:
        return self

    def __exit__(self, *_: Any) -> None:
        self._file.close()

    def error(self, path: str, cause: str) -> InputError:
        return InputError(f"{self.name}: {path}: {cause}")

    def has(self, path: str) -> bool:
        at = self._file
        for part in path.split("/"):
            if part not in at:
                return False
            if isinstance(at.get(part, getlink=True), self._h5py.ExternalLink):
                raise self.error(path, "is in another file, which is not read")
            at = at[part]
        return True

    def numbers(self, path: str, kind: type = float) -> np.ndarray:
        if not self.has(path):
            raise self.error(path, "is missing")
        data = self._file[path]
        if not isinstance(data, self._h5py.Dataset) or data.dtype.kind not in "iuf":
            raise self.error(path, "is no dataset of numbers")
        if data.external or data.is_virtual:
            raise self.error(path, "its numbers are in another file, which is not read")
        if data.size > min(_MOST, os.path.getsize(self.name)):
            raise self.error(path, f"has {data.size} numbers, more than the file has bytes, or than {_MOST}")
        values = np.ravel(data[()]).astype(kind)
        if not np.isfinite(values).all():
            raise self.error(path, f"[{np.flatnonzero(~np.isfinite(values))[0]}] is not finite")
        return values

    def integer(self, path: str) -> int:
        values = self.numbers(path, int)
        if values.shape != (1,):
            raise self.error(path, f"has {len(values)} numbers, expected 1")
        return int(values[0])

    def vector(self, path: str, size: int) -> np.ndarray:
        values = self.numbers(path)
        if len(values) != size:
            raise self.error(path, f"has {len(values)} entries, expected {size}")
        return values

    def matrix(self, path: str) -> Any:
        """Triplets as Siconos writes them have the column in p and the row in i; fclib.h says the reverse, and is right
        where only that fits the sizes."""
        from scipy.sparse import coo_matrix, csc_matrix, csr_matrix

        shape = self.integer(f"{path}/m"), self.integer(f"{path}/n")
        kind = self.integer(f"{path}/nz")
        if min(shape) < 0 or kind < -2 or max(shape) > min(_MOST, os.path.getsize(self.name)):
            raise self.error(path, f"{shape[0]} x {shape[1]} is no size of a matrix in this file")
        p, i = (self.numbers(f"{path}/{each}", np.int64) for each in "pi")
        x = self.numbers(f"{path}/x")
        try:
            if kind >= 0:
                i, p, x = i[:kind], p[:kind], x[:kind]
                turned = max(i, default=-1) >= shape[0] or max(p, default=-1) >= shape[1]
                return coo_matrix((x, (p, i) if turned else (i, p)), shape=shape).tocsc()
            p = p[: (shape[1] if kind == -1 else shape[0]) + 1]
            count = int(p[-1])
            result = (csc_matrix if kind == -1 else csr_matrix)((x[:count], i[:count], p), shape=shape)
            result.check_format(full_check=True)
            return result.tocsc()
        except (ValueError, IndexError) as error:
            raise self.error(path, f"is no sparse matrix: {error}") from None

    def symmetric(self, path: str, symmetrize: bool) -> Any:
        matrix = self.matrix(path)
        if matrix.shape[0] != matrix.shape[1]:
            raise self.error(path, f"is {matrix.shape[0]} x {matrix.shape[1]}, expected a square matrix")
        apart, largest = (abs(each).max() if each.nnz else 0.0 for each in (matrix - matrix.T, matrix))
        if apart > _ROUNDING * largest and not symmetrize:
            raise self.error(path, f"is not symmetric: its triangles differ by {apart:.3g}, its largest entry is "
                                   f"{largest:.3g}; symmetrize=True (--symmetrize) takes their mean")
        return (0.5 * (matrix + matrix.T)).tocsc()

    def blocks(self, path: str, symmetrize: bool) -> list[np.ndarray]:
        """The diagonal blocks that no entry leaves."""
        matrix = self.symmetric(path, symmetrize).tocoo()
        last = np.arange(matrix.shape[0])
        np.maximum.at(last, matrix.col, matrix.row)
        ends = [0, *(np.flatnonzero(np.maximum.accumulate(last) == np.arange(len(last))) + 1)]
        if sum((b - a) ** 2 for a, b in zip(ends, ends[1:])) > _MOST:
            raise self.error(path, f"its dense diagonal blocks have more than {_MOST} numbers")
        matrix = matrix.tocsc()
        return [matrix[a:b, a:b].toarray() for a, b in zip(ends, ends[1:])]


def load(path: Any, *, symmetrize: bool = False) -> Problem:
    """Reads a global or local problem of FCLIB. Solutions and guesses in the file are not read.

    Args:
        path: an HDF5 file.
        symmetrize: takes M or W also where it differs from its transpose by more than 1e-10 of its largest entry, and
            the mean of the two.

    Returns:
        A Problem that is named after the file.

    Raises:
        InputError: names file, dataset and cause: what is damaged or larger than the file, M that is not positive
            definite, or what is outside of the model: rolling friction.
    """
    name = _path(path)
    with _File(name) as file:
        group = next((each for each in ("fclib_global", "fclib_local") if file.has(each)), "")
        for each in ("fclib_global_rolling", "fclib_local_rolling"):
            if file.has(each):
                raise file.error(each, "rolling friction is outside of the model")
        if not group:
            raise InputError(f"{name}: has neither fclib_global nor fclib_local")
        dimension = file.integer(f"{group}/spacedim")
        if dimension not in (2, 3):
            raise file.error(f"{group}/spacedim", f"is {dimension}, expected 2 or 3")
        equality = f"{group}/{'G' if group == 'fclib_global' else 'V'}"
        equalities = file.integer(f"{equality}/n") if file.has(f"{equality}/n") else 0
        offsets: dict[str, Any] = {}
        rows: dict[str, Any] = dict(lower=None, upper=None)
        if equalities:
            rows["R"] = file.matrix(equality)
        if group == "fclib_global":
            blocks, H = file.blocks(f"{group}/M", symmetrize), file.matrix(f"{group}/H")
            f = file.vector(f"{group}/vectors/f", sum(map(len, blocks)))
            if H.shape[0] != len(f) or H.shape[1] % dimension:
                raise file.error(f"{group}/H", f"is {H.shape[0]} x {H.shape[1]}, expected {len(f)} rows, and a multiple "
                                               f"of {dimension} columns")
            try:
                for block in blocks:
                    np.linalg.cholesky(block)
            except np.linalg.LinAlgError:
                raise file.error(f"{group}/M", "is not positive definite") from None
            ends = np.cumsum([0, *map(len, blocks)])
            v = np.concatenate([np.linalg.solve(each, f[a:b]) for each, a, b in zip(blocks, ends, ends[1:])] or [f])
            w = file.vector(f"{group}/vectors/w", H.shape[1]).reshape(-1, dimension)
            if w.any():
                offsets = dict(b=w[:, 0], offset_t=np.hstack([w[:, 1:], np.zeros((len(w), 3 - dimension))]))
            inertia: dict[str, Any] = {"G": blocks}
            if equalities:
                rows["b"] = file.vector(f"{group}/vectors/b", equalities)
        else:
            from scipy.sparse import eye, identity

            W = file.symmetric(f"{group}/W", symmetrize)
            if W.shape[0] ** 2 > _MOST:
                raise file.error(f"{group}/W", f"{W.shape[0]} rows are too many for a dense matrix")
            if W.shape[0] % dimension:
                raise file.error(f"{group}/W", f"{W.shape[0]} rows are no multiple of {dimension}")
            inertia, v, H = {"Ginv": W.toarray()}, file.vector(f"{group}/vectors/q", W.shape[0]), identity(W.shape[0])
            if equalities:
                V, R = rows["R"].toarray(), file.symmetric(f"{group}/R", symmetrize).toarray()
                if V.shape[0] != len(v) or len(R) != equalities or (len(v) + equalities) ** 2 > _MOST:
                    raise file.error(equality, f"is {V.shape[0]} x {equalities}, beside a W of {len(v)} rows and an R of {len(R)}")
                inertia = {"Ginv": np.block([[W.toarray(), V], [V.T, R]])}
                H, rows["R"] = eye(len(v) + equalities, len(v)), eye(len(v) + equalities, equalities, -len(v))
                v = np.concatenate([v, file.vector(f"{group}/vectors/s", equalities)])
        H = H.tocsc()
        nc = H.shape[1] // dimension
        mu, tangents = file.vector(f"{group}/vectors/mu", nc), np.arange(H.shape[1]).reshape(nc, dimension)[:, 1:]
        if dimension == 3:
            friction = dict(tangents=H[:, tangents.ravel()])
        else:
            twice = np.repeat(tangents, 2)
            friction = dict(D=H[:, twice].multiply(np.tile([1.0, -1.0], nc)).tocsc(), edges=2)
        try:
            return Problem(**inertia, **friction, **offsets, N=H[:, ::dimension], mu=mu, v=v,
                           rows=rows if equalities else None, name=os.path.basename(name))
        except InputError as error:
            raise InputError(f"{name}: {group}: {error}") from None


def _dimension(problem: Problem) -> int:
    return 2 if problem.nc and set(problem.edges) <= {0, 2} and np.any(problem.edges) else 3


def _why_not(problem: Problem) -> str:
    """Why FCLIB cannot hold the problem, or ""."""
    if problem.kind == "lcp":
        return "a bare LCP is no problem of contacts"
    rows = problem.rows
    if problem.compliance_n.any() or problem.compliance_t.any() or (rows and rows["compliance"].any()):
        return "FCLIB has no compliance"
    if rows and (np.isfinite(rows["lower"]) | np.isfinite(rows["upper"]) | (np.array(rows["friction_of"]) >= 0)).any():
        return "of bounded rows FCLIB has equality constraints alone"
    if _dimension(problem) == 3 and (why := _native.why_no_round_cone(problem._data)):
        return f"FCLIB has the friction disc alone: {why}"
    return ""


def _directions(problem: Problem) -> tuple[Any, int]:
    """H, sparse, and the dimension of the space."""
    from scipy.sparse import csc_matrix, hstack

    edges, nc, dimension = np.asarray(problem.edges), problem.nc, _dimension(problem)
    D, first = csc_matrix(problem.D), np.cumsum(edges) - edges
    parts, none = [csc_matrix(problem.N)], csc_matrix((len(problem.v), 1))
    wide = hstack([D, none]).tocsc()  # the last column for contacts without friction
    for turn in range(dimension - 1):
        parts.append(wide[:, np.where(edges > 0, first + turn * edges // 4, D.shape[1])])
    return hstack(parts).tocsc()[:, np.arange(dimension * nc).reshape(dimension, nc).T.ravel()], dimension


def _write_matrix(group: Any, name: str, matrix: Any) -> None:
    matrix = matrix.tocsc()
    matrix.sort_indices()
    part = group.create_group(name)
    for key, value in (("nzmax", matrix.nnz), ("m", matrix.shape[0]), ("n", matrix.shape[1]), ("nz", -1)):
        part[key] = np.array([value], np.int32)
    part["p"], part["i"], part["x"] = matrix.indptr.astype(np.int32), matrix.indices.astype(np.int32), matrix.data


def save(problem: Problem | Step, path: Any, answer: Answer | None = None) -> None:
    """Writes a problem of contacts as libfclib reads it: global, or local where only G^-1 is known. Bounded rows without
    bounds are its equality constraints.

    Args:
        problem: a Problem, or a Step. Friction directions that form a regular polygon are written as the disc around
            them; contacts with two each are those of a plane.
        path: the file; what it held is lost.
        answer: an Answer of the problem, which is written as its solution. Of a disc it should obey the round cone,
            as "cone_ipm{cone=true}" does.

    Raises:
        InputError: a bare LCP, compliance, other bounded rows, or friction directions without a round cone; the file
            cannot be written.
    """
    from scipy.sparse import block_diag, csc_matrix

    h5py, whole, name = _h5py(), _problem(problem), _path(path)
    if why := _why_not(whole):
        raise InputError(f"problem: {why}")
    H, dimension = _directions(whole)
    inertia, local, rows = whole.G, whole.G is None, whole.rows
    offset = np.column_stack([whole.b, whole.offset_t.reshape(-1, 2)[:, : dimension - 1]]).ravel()
    try:
        file = h5py.File(name, "w")
    except OSError as error:
        raise InputError(f"{name}: cannot be written: {error}") from None
    with file:
        group = file.create_group("fclib_local" if local else "fclib_global")
        group["spacedim"], vectors = np.array([dimension], np.int32), group.create_group("vectors")
        vectors["mu"] = whole.mu
        if local:
            _write_matrix(group, "W", csc_matrix(H.T @ whole.Ginv @ H))
            vectors["q"] = H.T @ whole.v + offset
            if rows:
                _write_matrix(group, "V", csc_matrix(H.T @ whole.Ginv @ rows["R"]))
                _write_matrix(group, "R", csc_matrix(rows["R"].T @ whole.Ginv @ rows["R"]))
                vectors["s"] = rows["R"].T @ whole.v + rows["b"]
        else:
            M = block_diag(inertia) if isinstance(inertia, list) else csc_matrix(inertia)
            _write_matrix(group, "M", M)
            _write_matrix(group, "H", H)
            vectors["f"], vectors["w"] = M @ whole.v, offset
            if rows:
                _write_matrix(group, "G", csc_matrix(rows["R"]))
                vectors["b"] = rows["b"]
        info = group.create_group("info")
        for key, text in (("title", whole.name), ("description", f"written by lcpbench {_native.__version__}"),
                          ("math_info", "")):
            info[key] = np.array(text.encode(), f"S{len(text.encode()) + 1}")
        if answer is not None:
            solution = file.create_group("solution")
            solution["v"], solution["u"] = answer.velocity, H.T @ answer.velocity + offset
            solution["r"] = answer.impulses[:, :dimension].ravel()
            if rows:
                solution["l"] = answer.row_impulses


def main() -> None:
    import argparse

    parser = argparse.ArgumentParser(prog="python -m lcpbench.fclib", description="FCLIB files from steps, and back.")
    parser.add_argument("file", nargs="+", help="F.scenes, or FCLIB files")
    parser.add_argument("--out", required=True, help="folder of FCLIB files, or F.scenes")
    parser.add_argument("--symmetrize", action="store_true", help="take the mean of a matrix and its transpose")
    given = parser.parse_args()
    try:
        if given.out.endswith(".scenes"):
            problems = [load(each, symmetrize=given.symmetrize) for each in given.file]
            with Recorder(given.out, ", ".join(given.file), engine="FCLIB") as recorder:
                for problem in problems:
                    recorder.add(problem)
            return
        os.makedirs(given.out, exist_ok=True)
        written, left_out = 0, Counter[str]()
        for each in given.file:
            stem = os.path.basename(each).removesuffix(".scenes")
            for step in Scenes(each):
                if why := _why_not(_problem(step)):
                    left_out[why] += 1
                    continue
                save(step, os.path.join(given.out, f"{stem}-{step.step}.hdf5"))
                written += 1
        for why, count in left_out.items():
            print(f"lcpbench: {count} of {written + left_out.total()} steps left out: {why}", file=sys.stderr)
        if not written:
            parser.exit(2, f"lcpbench: {given.out}: no step was written\n")
    except (InputError, OSError) as error:
        parser.exit(2, f"lcpbench: {error}\n")


if __name__ == "__main__":
    main()
