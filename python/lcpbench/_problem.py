"""Problems."""

from __future__ import annotations

import difflib
from typing import Any, Iterable, Mapping, Sequence

import numpy as np

from . import _native
from ._native import InputError

BODY = {"position": np.zeros(3), "linear_velocity": np.zeros(3), "angular_velocity": np.zeros(3)}  # defaults
FIELDS = ("v", "N", "D", "mu", "b", "G", "Ginv", "edges", "points", "M", "q", "compliance_n", "compliance_t", "offset_t",
          "lower", "upper", "friction_of", "rows")
CONTACT = {"body_b": -1, "mu": 0.0, "b": 0.0, "tangent": None, "edges": None, "compliance_n": 0.0, "compliance_t": 0.0,
           "offset_t": np.zeros(2)}


def _integer(value: Any, name: str, largest: int = 2**30) -> int:
    try:
        number = int(value)
        if isinstance(value, bool) or number != value or abs(number) > largest:
            raise ValueError
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"{name} is {value!r}, expected an integer from {-largest} to {largest}") from None
    return number


def _number(value: Any, name: str) -> float:
    try:
        return float(value)
    except (TypeError, ValueError):
        raise InputError(f"{name} is {value!r}, expected a number") from None


def _did_you_mean(word: str, known: Iterable[str]) -> str:
    near = difflib.get_close_matches(word, list(known), 1)
    return f" (did you mean '{near[0]}'?)" if near else ""


def _name(value: Any) -> str:
    if not isinstance(value, str):
        raise InputError(f"name is {value!r}, expected a text")
    return value


def _shape(value: Any, name: str) -> tuple[int, ...]:
    try:
        return tuple(value.shape) if hasattr(value, "shape") else np.shape(value)
    except ValueError:
        raise TypeError(f"{name}: expected an array of numbers, and its rows differ in length") from None


def _columns(value: Any, name: str) -> int:
    shape = _shape(value, name)
    if len(shape) != 2:
        raise InputError(f"{name} has shape {shape}, expected (ngc, columns)")
    return int(shape[1])


def _checked(value: Any, name: str) -> Any:
    """A matrix of scipy.sparse whose pointers and indices fit its shape; anything else as it is. Neither scipy's own
    constructors nor its conversions look at all of them."""
    if not hasattr(value, "tocsc"):
        return value
    try:
        for field in ("indptr", "indices", "row", "col"):
            if getattr(value, field, np.arange(0)).dtype.kind not in "iu":
                raise ValueError(f"{field} holds {getattr(value, field).dtype}, expected integers")
        if hasattr(value, "check_format"):
            value.check_format(full_check=True)
            return value
        value = value.tocoo()
        for index, size in zip((value.row, value.col), value.shape):
            if len(index) != len(value.data) or np.any((index < 0) | (index >= size)):
                raise ValueError("an index is outside of its shape")
        return value
    except (TypeError, ValueError) as error:
        raise InputError(f"{name} is no sparse matrix: {error}") from None


def _edge_counts(edges: Any, nc: int, friction: int) -> list[int]:
    if edges is None:
        if nc == 0 or friction % nc != 0:
            if friction == 0:
                return [0] * nc
            raise InputError(f"edges: D has {friction} columns, which {nc} contacts do not share evenly; give edges")
        edges = friction // nc
    if _shape(edges, "edges") == ():
        counts = [_integer(edges, "edges")] * nc
    else:
        counts = [_integer(each, f"edges[{i}]") for i, each in enumerate(edges)]
    if len(counts) != nc:
        raise InputError(f"edges has {len(counts)} entries, expected {nc}: one for each column of N")
    for i, count in enumerate(counts):
        if count < 0 or count % 2 != 0:
            raise InputError(f"edges[{i}] is {count}, expected an even number >= 0")
    return counts


def _impulse_rows(edges: Sequence[int], f: Any) -> np.ndarray:
    """(nc, 3) of f_N and f_D: the impulses along each contact's normal and both tangents."""
    result = np.zeros((len(edges), 3))
    result[:, 0] = f[: len(edges)]
    at = len(edges)
    for i, count in enumerate(edges):
        turn = np.exp(2j * np.pi * np.arange(count) / max(count, 1)).round(15)  # 4 edges: exactly 0 and +-1
        result[i, 1:] = f[at : at + count] @ np.column_stack([turn.real, turn.imag])
        at += count
    return result


def _pyramids(tangents: Any, mu: np.ndarray, nc: int) -> tuple[Any, list[int]]:
    """Four edges t1, t2, -t1, -t2 for each contact that has friction."""
    if _columns(tangents, "tangents") != 2 * nc:
        raise InputError(f"tangents has {_columns(tangents, 'tangents')} columns, expected 2 nc = {2 * nc}")
    edges = [4 if m > 0 else 0 for m in mu]
    columns = np.array([4 * [2 * i] for i in range(nc) if edges[i]], dtype=int).reshape(-1, 4) + [0, 1, 0, 1]
    signs = np.tile([1.0, 1.0, -1.0, -1.0], len(columns))
    if hasattr(tangents, "tocsc"):
        return tangents.tocsc()[:, columns.ravel()].multiply(signs).tocsc(), edges
    return np.asarray(tangents, dtype=float)[:, columns.ravel()] * signs, edges


def _size(values: Any, name: str) -> int:
    shape = _shape(values, name)
    if len(shape) != 1:
        raise InputError(f"{name} has shape {shape}, expected (n,)")
    return int(shape[0])


def _with_none(values: Any, name: str, n: int, none: float) -> np.ndarray:
    """(n,), with `none` where None stands."""
    if values is None or _shape(values, name) == ():
        return np.full(n, none if values is None else _number(values, name))
    if _size(values, name) != n:
        raise InputError(f"{name} has shape {_shape(values, name)}, expected ({n},)")
    return np.array([none if each is None else _number(each, f"{name}[{i}]") for i, each in enumerate(values)])


def _bounds(n: int, lower: Any, upper: Any, friction_of: Any, mu: Any) -> tuple[Any, ...]:
    """lower, upper, friction_of and mu of n entries each; no entries of a bare LCP."""
    if lower is None and upper is None and friction_of is None:
        return np.zeros(0), np.zeros(0), [], np.zeros(0)
    of = [_integer(each, f"friction_of[{i}]") for i, each in enumerate(_with_none(friction_of, "friction_of", n, -1))]
    rows = np.array(of, dtype=int) >= 0
    low = _with_none(lower, "lower", n, 0.0 if lower is None else -np.inf)
    if lower is None:
        low[rows] = -np.inf
    if rows.any() and mu is None:
        raise InputError("mu is missing: there are rows of friction")
    return low, _with_none(upper, "upper", n, np.inf), of, np.where(rows, _with_none(mu, "mu", n, 0.0), 0.0)


ROWS = ("R", "lower", "upper", "b", "compliance", "friction_of", "mu", "unit", "names")


def _row_texts(values: Any, name: str, m: int) -> list[str]:
    if isinstance(values, str) or not isinstance(values, Iterable):
        raise TypeError(f"{name}: expected a list of texts, got {type(values).__name__}")
    texts = list(values)
    for i, each in enumerate(texts):
        if not isinstance(each, str):
            raise TypeError(f"{name}[{i}]: expected a text, got {type(each).__name__}")
    if len(texts) != m:
        raise InputError(f"{name} has {len(texts)} entries, expected {m}: one for each column of rows.R")
    return texts


def _bounded_rows(rows: Any) -> dict[str, Any] | None:
    """All fields of the rows, m entries each; None where there are no rows."""
    if rows is None:
        return None
    full = _full(rows, "rows", dict.fromkeys(ROWS[3:]), ROWS[:3])
    R = full["R"] = _checked(full["R"], "rows.R")
    m = _columns(R, "rows.R")
    if full["mu"] is not None and full["friction_of"] is None:
        raise InputError("rows.mu: belongs to rows.friction_of")
    of = [_integer(each, f"rows.friction_of[{i}]")
          for i, each in enumerate(_with_none(full["friction_of"], "rows.friction_of", m, -1))]
    loaded = np.array(of, dtype=int) >= 0
    if loaded.any() and full["mu"] is None:
        raise InputError("rows.mu is missing: there are rows of friction")
    for key, none in (("lower", -np.inf), ("upper", np.inf)):
        one_for_all = full[key] is not None and _shape(full[key], f"rows.{key}") == ()
        full[key] = _with_none(full[key], f"rows.{key}", m, none)
        if one_for_all:
            full[key][loaded] = none
    for key in ("b", "compliance"):
        if full[key] is None or _shape(full[key], f"rows.{key}") == ():
            full[key] = np.full(m, 0.0 if full[key] is None else _number(full[key], f"rows.{key}"))
    unit = full["unit"] or "m"
    units = [unit] * m if isinstance(unit, str) else _row_texts(unit, "rows.unit", m)
    for i, each in enumerate(units):
        if each not in ("m", "rad"):
            raise InputError(f"rows.unit[{i}] is {each!r}, expected 'm' or 'rad'")
    names = [] if full["names"] is None else _row_texts(full["names"], "rows.names", m)
    return {**full, "friction_of": of, "mu": np.where(loaded, _with_none(full["mu"], "rows.mu", m, 0.0), 0.0),
            "unit": [each == "rad" for each in units], "names": names}


class Problem:
    """One time step's contacts: find impulses under which no contact approaches and friction opposes slip.

    With ngc generalized coordinates and nc contacts, v+ = v + inv(G) (N f_N + D f_D) is the velocity after the step,
    and each contact keeps 0 <= f_N, w >= 0, f_N w = 0 with w = N'v+ + b, and friction in a pyramid of its edges. A soft
    contact gives way: w = N'v+ + b + compliance_n f_N, and its friction opposes the tangential velocity + offset_t +
    compliance_t f_T, where f_T is its impulse along both tangents. Bounded rows stand for joints, limits, motors and dry
    friction in joints: with R f_R beside N f_N + D f_D, each keeps lower <= f_R <= upper for w = R'v+ + b + compliance f_R,
    and w >= 0 at its lower bound, <= 0 at its upper, 0 between. Data are copied and never change.

    Args:
        G: inertia [kg, kg m^2]: (ngc, ngc), symmetric positive definite, or a list of its diagonal blocks. Mirrored
            entries may differ by rounding (1e-9 of the largest); the mean is taken.
        N: (ngc, nc), dense or scipy.sparse: column i is the direction that contact i pushes in.
        D: (ngc, sum(edges)), dense or scipy.sparse: friction directions grouped by contact; inside a contact column
            t + edges/2 is the negative of column t. None: no friction.
        mu: (nc,) or one number: coefficients of friction >= 0. Contacts without friction directions have 0.
        v: (ngc,): velocity at the end of the step without contacts, forces included [m/s, rad/s].
        b: (nc,): offset of the normal velocity [m/s]: gap / h, restitution times the approach, or None for zeros.
        edges: (nc,) or one number: how many columns of D each contact has. None: all the same.
        compliance_n: (nc,) or one number >= 0: softness along the normals [m/s per N s]. None: hard contacts.
        compliance_t: (nc,) or one number >= 0: softness of the contacts with friction along their tangents, alike.
        offset_t: (2 nc,) or (nc, 2): offset of the velocity along both tangents of contacts with friction [m/s].
        tangents: (ngc, 2 nc), instead of D: both unit tangents of each contact, which get a pyramid of four edges. That they
            are at right angles is the caller's promise, not tested.
        rows: a dict of bounded rows, or None: R, (ngc, m), dense or scipy.sparse; lower <= 0 and upper >= 0, (m,) or one
            number [N s, N m s], infinite or None where there is none. Optional: b [m/s, rad/s], compliance [m/s per N s, rad/s
            per N m s], (m,) or one number; friction_of, (m,), with mu: row i is bounded by +-mu[i] f_R[friction_of[i]], -1 or
            None: by lower and upper; unit, "m" or "rad", (m,) or one for all; names, m texts.
        G_factors: (X, alpha), instead of G: G = X diag(alpha) X', of any rank.
        Ginv: (ngc, ngc), instead of G: its inverse, where nothing else is known.
        M, q: (n, n) and (n,), instead of all others: a bare LCP, z >= 0, M z + q >= 0, z'(M z + q) = 0.
        lower, upper: (n,) or one number, of a mixed LCP: bounds of z, infinite or None where there is none. w = M z + q is
            >= 0 at the lower bound, <= 0 at the upper, 0 between. None: 0, and no upper bounds.
        friction_of: (n,), with mu (n,) or one number: row i is bounded by +-mu[i] z[friction_of[i]], a box of friction
            that is a model of its own. -1 or None: by lower and upper. Counted from 0.
        name: a text.
        validate: False: the caller's promise, not tested, that G is positive definite, D comes in pairs, all is finite.

    Attributes:
        v, N, D, mu, edges, G, Ginv: as given; G None where it is not known.
        b, compliance_n, compliance_t (nc,), offset_t (2 nc,): zeros where none was given.
        rows: a dict with all fields, names None where there are none; None without rows.
        M, q: the LCP, formed on first use.
        lower, upper, friction_of, mu: of an LCP.
        points: (nc, 3) [m] of a problem from bodies, or None.
        engine_impulses, engine_row_impulses: of a captured step those that the engine found, as `Step.impulses` and
            `Step.row_impulses`; else None.

    Raises:
        InputError: an argument is missing, has another shape, is not finite, or does not fit the others.
        TypeError: an argument holds no numbers.
    """

    __slots__ = ("_data", "_contact_names", "_engine_model", "engine_impulses", "engine_row_impulses")
    _data: _native.Problem
    _contact_names: list[str]  # for sentences: those of the Step that it is part of
    _engine_model: str | None  # the friction that the engine solves, where it is not the problem's own

    def __init__(self, *, G: Any = None, N: Any = None, D: Any = None, mu: Any = None, v: Any = None, b: Any = None,
                 edges: Any = None, tangents: Any = None, compliance_n: Any = None, compliance_t: Any = None,
                 offset_t: Any = None, rows: Any = None, G_factors: Any = None, Ginv: Any = None, M: Any = None,
                 q: Any = None, lower: Any = None, upper: Any = None, friction_of: Any = None, name: str = "problem",
                 validate: bool = True) -> None:
        _name(name)
        self._contact_names, self._engine_model = [], None
        self.engine_impulses, self.engine_row_impulses = None, None
        if M is not None or q is not None:
            others = dict(G=G, N=N, D=D, mu=mu if friction_of is None else None, v=v, b=b, edges=edges,
                          tangents=tangents, compliance_n=compliance_n,
                          compliance_t=compliance_t, offset_t=offset_t, rows=rows, G_factors=G_factors, Ginv=Ginv)
            extra = next((f", and not {key}" for key, value in others.items() if value is not None), "")
            if extra or M is None or q is None:
                raise InputError("a bare LCP has M and q" + (extra or " both"))
            self._data = _native.bare(M, q, *_bounds(_size(q, "q"), lower, upper, friction_of, mu), name)
            return
        for key, value in dict(lower=lower, upper=upper, friction_of=friction_of).items():
            if value is not None:
                raise InputError(f"{key}: belongs to M and q")
        inertia = {"G": G, "G_factors": G_factors, "Ginv": Ginv}
        given = [key for key, value in inertia.items() if value is not None]
        if len(given) != 1:
            raise InputError(f"expected one of G, G_factors and Ginv, got {' and '.join(given) or 'none'}")
        if N is None or v is None:
            raise InputError(f"{'N' if N is None else 'v'} is missing")
        kind, value = given[0], inertia[given[0]]
        if kind == "G" and (isinstance(value, (list, tuple)) and value and len(_shape(value[0], "G[0]")) == 2):
            kind = "G_blocks"
        elif kind == "G" and hasattr(value, "toarray"):
            value = _checked(value, "G").toarray()
        if kind == "G_factors" and (not isinstance(value, (tuple, list)) or len(value) != 2):
            raise InputError("G_factors: expected the pair (X, alpha)")
        N, D, tangents = _checked(N, "N"), _checked(D, "D"), _checked(tangents, "tangents")
        nc, bounded = _columns(N, "N"), _bounded_rows(rows)
        for matrix, text in ((N, "N"), (D, "D"), (tangents, "tangents"), (bounded and bounded["R"], "rows.R")):
            shape, ngc = (() if matrix is None else _shape(matrix, text)), _shape(v, "v")
            if len(shape) == 2 and len(ngc) == 1 and shape[0] != ngc[0] == shape[1]:
                raise InputError(f"{text} has shape {shape}, expected ({ngc[0]}, columns): this is the transpose")
        if tangents is not None and (D is not None or edges is not None):
            raise InputError("tangents stand in place of D and edges, not beside them")
        if mu is None and (tangents is not None or D is not None):
            raise InputError("mu is missing: there are friction directions")
        if mu is None or _shape(mu, "mu") == ():
            mu = np.full(nc, 0.0 if mu is None else _number(mu, "mu"))
        if tangents is not None:
            if _shape(mu, "mu") != (nc,):
                raise InputError(f"mu has shape {_shape(mu, 'mu')}, expected ({nc},)")
            D, counts = _pyramids(tangents, mu, nc)
        else:
            counts = _edge_counts(edges, nc, 0 if D is None else _columns(D, "D"))
        if D is None and any(counts):
            raise InputError("D is missing: edges has friction directions")
        if compliance_n is not None and _shape(compliance_n, "compliance_n") == ():
            compliance_n = np.full(nc, _number(compliance_n, "compliance_n"))
        if compliance_t is not None and _shape(compliance_t, "compliance_t") == ():
            compliance_t = np.where(np.array(counts) > 0, _number(compliance_t, "compliance_t"), 0.0)
        if offset_t is not None and _shape(offset_t, "offset_t") == (nc, 2):
            offset_t = np.ravel(offset_t)
        self._data = _native.contacts(v, N, D, counts, mu, b, compliance_n, compliance_t, offset_t, bounded, kind, value,
                                      name, validate)

    @classmethod
    def _of(cls, data: _native.Problem) -> Problem:
        result = cls.__new__(cls)
        result._data, result._contact_names, result._engine_model = data, [], None
        result.engine_impulses, result.engine_row_impulses = None, None
        return result

    @classmethod
    def from_scene(cls, bodies: Iterable[Mapping[str, Any]], contacts: Iterable[Mapping[str, Any]],
                   name: str = "scene") -> Problem:
        """Free rigid bodies and contact points, in world axes.

        Args:
            bodies: each a dict with mass [kg] and inertia about the centre of mass (3, 3) [kg m^2], and position,
                linear_velocity, angular_velocity of (3,), which are zero by default.
            contacts: each a dict with body_a, the body that is pushed along normal; body_b, -1 (default) for the
                immovable world; point (3,) [m]; normal (3,), a unit vector from body_b into body_a; mu (default 0);
                tangent (3,), a unit vector orthogonal to normal (default: any); edges, 4 with friction and 0 without;
                b [m/s], compliance_n, compliance_t and offset_t of (2,) as those of a Problem (default 0).
            name: a text.

        Raises:
            InputError: names the body or the contact, and the field.
        """
        full_bodies: list[dict[str, Any]] = []
        for i, body in enumerate(bodies):
            full_bodies.append(_full(body, f"bodies[{i}]", BODY, ("mass", "inertia")))
            full_bodies[-1]["mass"] = _number(body["mass"], f"bodies[{i}].mass")
        full_contacts: list[dict[str, Any]] = []
        for i, contact in enumerate(contacts):
            at = f"contacts[{i}]"
            full = _full(contact, at, CONTACT, ("body_a", "point", "normal"))
            for key in ("mu", "b", "compliance_n", "compliance_t"):
                full[key] = _number(full[key], f"{at}.{key}")
            full["edges"] = (4 if full["mu"] > 0 else 0) if full["edges"] is None else full["edges"]
            for key in ("body_a", "body_b", "edges"):
                full[key] = _integer(full[key], f"{at}.{key}")
            if full["tangent"] is None:
                full["tangent"] = _any_tangent(full["normal"], at)
            full_contacts.append(full)
        return cls._of(_native.scene(full_bodies, full_contacts, _name(name)))

    @property
    def name(self) -> str:
        """The problem's name."""
        return self._data.name

    @property
    def kind(self) -> str:
        """"lcp", "contact" or "scene"."""
        return self._data.kind

    @property
    def size(self) -> int:
        """n, the number of unknowns of the LCP."""
        return self._data.size

    def __getattr__(self, field: str) -> Any:
        if field in FIELDS:
            return getattr(self._data, field)
        raise AttributeError(f"a Problem has no '{field}'{_did_you_mean(field, FIELDS)}")

    @property
    def nc(self) -> int:
        """Number of contacts; 0 for a bare LCP."""
        return 0 if self.kind == "lcp" else len(self._data.edges)

    def _has_tangents(self) -> bool:
        """Whether the friction directions of each contact name two tangents."""
        return not _native.why_no_round_cone(self._data)

    def delassus(self) -> np.ndarray:
        """W = [N D]' inv(G) [N D] [1/kg, ...], dense: (nc + sum(edges),) squared."""
        J = np.hstack([each.toarray() if hasattr(each, "toarray") else each for each in (self.N, self.D)])
        return np.asarray(J.T @ self.Ginv @ J)

    def __eq__(self, other: object) -> bool:
        """The same numbers, bit for bit; names do not count."""
        if not isinstance(other, Problem):
            return NotImplemented
        if not _native.has_readers:
            return self is other
        return _native.problem_hash(self._data) == _native.problem_hash(other._data)

    __hash__ = None  # type: ignore[assignment]

    def __reduce__(self) -> Any:  # copy and pickle, for processes
        return _unpickled, (_native.problem_json(self._data),)

    def __repr__(self) -> str:
        if self.kind == "lcp":
            return f"<lcpbench.Problem '{self.name}': LCP of order {self.size}>"
        rough = int(np.count_nonzero(self._data.mu))
        m = self._data.row_count
        return (f"<lcpbench.Problem '{self.name}': {self.nc} contacts, {rough} with friction, "
                f"{f'{m} bounded rows, ' if m else ''}{len(self._data.v)} coordinates>")

    def _repr_html_(self) -> str:
        from ._picture import problem_html

        return problem_html(self)

    def figure(self, *answers: Any) -> Any:
        """A picture for notebooks: the contacts' impulses, one colour for each answer.

        Args:
            answers: at most four `Answer`s of this problem.
        """
        from ._picture import Figure

        return Figure(self, answers)


def _unpickled(text: str) -> Problem:
    return Problem._of(_native.parse_problem(text))


def _full(part: Any, at: str, defaults: dict[str, Any], required: Sequence[str]) -> dict[str, Any]:
    if not isinstance(part, Mapping):
        raise InputError(f"{at}: expected a dict, got {type(part).__name__}")
    for key in required:
        if key not in part:
            raise InputError(f"{at}.{key} is missing")
    for key in part:
        if key not in defaults and key not in required:
            known = sorted([*defaults, *required])
            raise InputError(f"{at}.{key}: unknown field{_did_you_mean(str(key), known)}; known: {', '.join(known)}")
    return {**defaults, **part}


def _any_tangent(normal: Any, at: str) -> np.ndarray:
    n = np.asarray(normal)
    if n.shape != (3,) or n.dtype.kind not in "biuf":
        raise InputError(f"{at}.normal has shape {n.shape}, expected (3,) numbers")
    t = np.cross(n, np.eye(3)[int(np.argmin(np.abs(n)))])
    length = float(np.linalg.norm(t))
    return t / length if length > 0 else t
