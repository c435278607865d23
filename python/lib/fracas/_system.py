"""Systems, solvers, and what they answer."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, TypedDict

import numpy as np

from . import _convert, _core, _parts
from ._convert import Vector, kind, rows, vector
from ._core import System as CoreSystem
from ._errors import InputError, SystemInputError, WrongType

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from ._operators import Operator, Preconditioner

class Settings(TypedDict, total=False):
    """How a system is solved; `System.solve` says what each means."""

    preconditioner: Any
    augmentation: Any
    inner: Any
    krylov: str | dict[str, Any] | None
    tol: float
    measure: str
    max_iterations: int
    traction_unit: float | None
    explain: bool
    linear: bool


#: Called with every `Event`; returning False stops the iteration, and what sets it up at its next look: a factorization, dense eigenvalues
#: and the exact C are waited for.
Observer = Callable[[_core.Event], Any]


@dataclass(frozen=True)
class Solution:
    """A system that was solved, or not: not converging is no exception.

    ``u``, ``t``, ``p`` are in the units of the system; ``report`` has the keys of ``fracas solve --json``, without those that
    tell of a file and of the program.
    """

    u: Vector
    t: Vector
    p: Vector
    x: Vector = field(repr=False)
    #: ``converged``, ``iteration_limit``, ``stopped`` or ``breakdown``.
    outcome: str
    iterations: int
    #: Errors of u and t, each relative to the solution's in the norm of energy; None where they are not known.
    error_u: float | None
    error_t: float | None
    #: ‖b − 𝒜x‖₂ / ‖b‖₂, recomputed at the end.
    relative_residual: float | None
    #: Wall time [s].
    setup_s: float
    solve_s: float
    #: Iteration, counted over all passes, and ‖r_k‖/‖b‖ as the recurrence estimates it.
    history: Vector = field(repr=False)
    #: Sentences: why an inner solver was chosen, what gave way.
    findings: list[str] = field(repr=False)
    #: Why it did not converge, or what to mind.
    reason: str | None
    report: dict[str, Any] = field(repr=False)

    @property
    def converged(self) -> bool:
        """True where the tolerance is met."""
        return self.outcome == "converged"

    @staticmethod
    def _of(packed: tuple[str, Vector, Any, Vector]) -> Solution:
        text, x, iterations, residuals = packed
        report = json.loads(text)
        n_u, n_t = report["n_u"], report["n_t"]
        return Solution(
            u=x[:n_u],
            t=x[n_u : n_u + n_t],
            p=x[n_u + n_t :],
            x=x,
            history=np.column_stack([iterations.astype(np.float64), residuals]),
            report=report,
            **{
                key: report[key]
                for key in (
                    "outcome",
                    "iterations",
                    "error_u",
                    "error_t",
                    "relative_residual",
                    "setup_s",
                    "solve_s",
                    "findings",
                    "reason",
                )
            },
        )


@dataclass(frozen=True)
class Part:
    """A closed set that eigenvalues lie in: ``interval``, ``box``, ``disc``, ``outside_disc``, ``half_plane`` or ``any_of``.

    Intervals concern real eigenvalues, all others those that are not real; discs have their centre on the real axis, which they cut at
    ``low`` and ``high``.
    """

    kind: str
    low: float | None = None
    high: float | None = None
    re_low: float | None = None
    re_high: float | None = None
    im_max: float | None = None
    parts: tuple[Part, ...] = ()

    @staticmethod
    def _of(told: dict[str, Any]) -> Part:
        parts = tuple(Part._of(part) for part in told.get("parts", ()))
        return Part(**{**told, "parts": parts})


@dataclass(frozen=True)
class Spectrum:
    """Eigenvalues of M⁻¹𝒜, what is proved about them, and whether it holds.

    ``report`` has the keys of ``fracas spectrum --json``, without those that tell of a file and of the program.
    """

    #: All of them, or the outer ones of a large system.
    eigenvalues: Any = field(repr=False)
    #: What is proved: every eigenvalue lies in every part.
    region: tuple[Part, ...]
    #: True, False, or None where nothing is proved.
    contained: bool | None
    #: In a sentence.
    verdict: str
    #: Ends of the real eigenvalues.
    real_min: float | None
    real_max: float | None
    report: dict[str, Any] = field(repr=False)

    @property
    def interval(self) -> tuple[float, float] | None:
        """The interval that is proved of real eigenvalues."""
        for part in self.region:
            if part.kind == "interval" and part.low is not None and part.high is not None:
                return part.low, part.high
        return None

    @staticmethod
    def _of(text: str) -> Spectrum:
        report = json.loads(text)
        values = report["eigenvalues"]
        return Spectrum(
            eigenvalues=np.array(values["re"]) + 1j * np.array(values["im"]),
            region=tuple(Part._of(part) for part in report["region"]),
            report=report,
            **{key: report[key] for key in ("contained", "verdict", "real_min", "real_max")},
        )


def _asked(
    preconditioner: Any = "racp",
    augmentation: Any = None,
    inner: Any = "auto",
    krylov: Any = None,
    tol: float = 1e-8,
    measure: str = "error",
    max_iterations: int = 1000,
    traction_unit: float | None = None,
    rhs: str | None = None,
    explain: bool = False,
    linear: bool = True,
) -> dict[str, Any]:
    def number(name: str, value: Any) -> float:
        try:
            return float(value)
        except (TypeError, ValueError) as error:
            raise WrongType(f"{name}: expected a number, not {kind(value)}") from error

    if not isinstance(max_iterations, (int, np.integer)) or max_iterations < 0:
        raise InputError(f"max_iterations = {max_iterations!r}: expected a number from 0 on")
    if krylov is not None and not isinstance(krylov, (str, dict)):
        raise WrongType(f"krylov: expected a name such as gmres:50, or settings, not {kind(krylov)}")
    if not isinstance(measure, str):
        raise WrongType(f"measure: expected error or residual, not {kind(measure)}")
    return {
        "preconditioner": _parts.preconditioner(preconditioner, linear),
        "augmentation": _parts.augmentation(augmentation),
        "inner": _parts.inner(inner, linear),
        "krylov": _convert.text(krylov) if isinstance(krylov, dict) else krylov,
        "measure": measure,
        "tol": number("tol", tol),
        "max_iterations": int(max_iterations),
        "traction_unit": None if traction_unit is None else number("traction_unit", traction_unit),
        "rhs": rhs,
        "explain": bool(explain),
    }


def _right_hand_side(rhs: Any) -> tuple[str | None, Vector | None]:
    if rhs is None or isinstance(rhs, str):
        return rhs, None
    return None, vector("rhs", rhs)


class Solver:
    """A preconditioner that is set up, for many right-hand sides; ``System.set_up`` makes it.

    >>> import fracas
    >>> system = fracas.Scene.gallery("patch").system()
    >>> solver = system.set_up(tol=1e-10)
    >>> [solver.solve(rhs).converged for rhs in (None, 2.0 * system.rhs)]
    [True, True]
    """

    def __init__(self, core: _core.Solver):
        self._core = core

    def solve(self, rhs: Any = None, *, observer: Observer | None = None) -> Solution:
        """Iterates from 0; ``rhs`` (n entries, in the units of the system) is kept for the calls that follow."""
        b = None if rhs is None else vector("rhs", rhs, self.n)
        return Solution._of(self._core.solve(b, observer))

    @property
    def n(self) -> int:
        """Unknowns."""
        return self._core.unknowns

    @property
    def setup_s(self) -> float:
        """Wall time of the set-up [s]."""
        return self._core.setup_s


class System:
    """A generalized saddle point ``[A B1; B2 −H]``, with flow ``[A B1 Q1; B2 −H 0; Q2 0 T]``.

    ``A`` (n_u × n_u, symmetric positive semi-definite), ``B1`` (n_u × n_t), ``B2`` (n_t × n_u; None is B1ᵀ), ``H`` (n_t × n_t; None is 0) and
    ``flow=(Q1, Q2, T)`` are scipy.sparse matrices or 2-D arrays; they are copied once, since the library owns what it works on. With
    ``share=True`` your matrices in compressed rows then show its memory, read-only, and theirs is given back. ``rhs`` has n_u + n_t (+ n_p) entries; ``coordinates`` are
    n_u rows x y z component, or n_u/3 rows x y z [m]: multigrid needs them for rotations.

    >>> import numpy as np, scipy.sparse as sp, fracas
    >>> A = sp.diags([-1.0, 2.0, -1.0], [-1, 0, 1], shape=(6, 6))
    >>> B = sp.csr_array(([1.0, -1.0], ([2, 3], [0, 0])), shape=(6, 1))
    >>> system = fracas.System(A, B, rhs=np.ones(7))
    >>> solution = system.solve(tol=1e-12)
    >>> solution.converged, float(np.abs(system.operator @ solution.x - 1.0).max()) < 1e-10
    (True, True)
    """

    _core: CoreSystem

    def __init__(
        self,
        A: Any,
        B1: Any,
        H: Any = None,
        B2: Any = None,
        rhs: Any = None,
        coordinates: Any = None,
        flow: tuple[Any, Any, Any] | None = None,
        *,
        share: bool = False,
    ):
        def optional(name: str, value: Any) -> Any:
            return None if value is None else rows(name, value)

        a, b1 = rows("A", A), rows("B1", B1)
        flows = None
        n = a[0] + b1[1]
        if flow is not None:
            if not isinstance(flow, (tuple, list)) or len(flow) != 3:
                raise WrongType(f"flow: expected (Q1, Q2, T), not {kind(flow)}")
            flows = tuple(rows(name, value) for name, value in zip(("Q1", "Q2", "T"), flow, strict=True))
            n += flows[2][0]
        self._core = _core.System(
            a,
            b1,
            optional("B2", B2),
            optional("H", H),
            flows,
            None if rhs is None else vector("rhs", rhs, n),
            _convert.coordinates(coordinates, a[0]),
        )
        if share:
            del a, b1
            for name, given in (("A", A), ("B1", B1), ("H", H), ("B2", B2)):
                _convert.share(given, self._core.block(name))

    @classmethod
    def _of(cls, core: CoreSystem) -> System:
        system = cls.__new__(cls)
        system._core = core
        return system

    @classmethod
    def read(cls, folder: str | os.PathLike[str]) -> System:
        """A system folder (A.mtx, B1.mtx, …), as `fracas export` and other codes write it."""
        return cls._of(_core.System.read(_path("folder", folder)))

    def write(self, folder: str | os.PathLike[str]) -> None:
        """Writes a system folder, which `fracas solve --system` and `System.read` take."""
        self._core.write(_path("folder", folder))

    @property
    def n_u(self) -> int:
        """Displacements."""
        return self._core.sizes[0]

    @property
    def n_t(self) -> int:
        """Tractions."""
        return self._core.sizes[1]

    @property
    def n_p(self) -> int:
        """Pressures."""
        return self._core.sizes[2]

    @property
    def n(self) -> int:
        """Unknowns in all."""
        return sum(self._core.sizes)

    @property
    def findings(self) -> list[str]:
        """What is remarkable about the matrices, a sentence each."""
        return self._core.findings

    def _block(self, name: str) -> Any:
        return _convert.matrix(self._core.block(name))

    @property
    def A(self) -> Any:
        """Stiffness as a scipy.sparse.csr_array; entries and columns are shared and read-only, as in all blocks."""
        return self._block("A")

    @property
    def B1(self) -> Any:
        """n_u × n_t."""
        return self._block("B1")

    @property
    def B2(self) -> Any:
        """n_t × n_u; a new matrix where it is B1ᵀ."""
        own = self._block("B2")
        return self.B1.T.tocsr() if own is None else own

    @property
    def H(self) -> Any:
        """n_t × n_t, or None; the block of 𝒜 is −H."""
        return self._block("H")

    @property
    def flow(self) -> tuple[Any, Any, Any] | None:
        """(Q1, Q2, T), or None."""
        q1 = self._block("Q1")
        return None if q1 is None else (q1, self._block("Q2"), self._block("T"))

    @property
    def rhs(self) -> Vector:
        """(rhs_u, rhs_t, rhs_p) as one vector: a copy."""
        return self._core.rhs

    @property
    def coordinates(self) -> Any:
        """n_u rows x y z component, or None: a copy."""
        return self._core.coordinates

    @property
    def traction_unit(self) -> float:
        """The power of two in which forces and jumps are of one size."""
        return self._core.traction_unit

    def in_traction_unit(self, unit: float | None = None) -> System:
        """The same system with tractions counted in ``unit`` (by default the balanced one): norms of residuals then see both rows."""
        return System._of(self._core.in_traction_unit(self.traction_unit if unit is None else float(unit)))

    def assembled(self) -> Any:
        """𝒜 as one scipy.sparse.csr_array: a copy."""
        block_array = _convert.sparse().block_array
        a, b1, b2, h = self.A, self.B1, self.B2, self.H
        grid = [[a, b1], [b2, None if h is None else -h]]
        if self.flow is not None:
            q1, q2, t = self.flow
            grid = [[*grid[0], q1], [*grid[1], None], [q2, None, t]]
        return block_array(grid, format="csr")

    def augmentation(self, name: str = "fitted_h") -> Any:
        """C of that name as a scipy.sparse.csr_array."""
        return _convert.matrix(self._core.augmentation(name).rows())

    def solve(self, *, rhs: Any = None, observer: Observer | None = None, **settings: Unpack[Settings]) -> Solution:
        """Sets up and solves. Settings, as of `fracas solve`:

        ``preconditioner="racp"`` (or mcp, direct, simple, …, settings such as ``{"racp": {"inner": "amg"}}``, or your own M⁻¹: a function of
        r, a LinearOperator, factors with ``solve``, or an object with ``prepare(system)``), ``augmentation=None`` (C: local, fitted_h, …, an
        array, a sparse matrix or a function of the system), ``inner="auto"`` (exact, amg, fsai, …, or a function of (S, coordinates)),
        ``krylov=None`` (gmres, gmres:50, fgmres, bicgstab, minres, sqmr, cg), ``tol=1e-8``, ``measure="error"`` (or residual),
        ``max_iterations=1000``, ``traction_unit=None``, ``explain=False``, ``linear=True`` (False: your M⁻¹ changes from call to call).

        ``rhs`` is None (of the system), ``"sin"``, ``"ones"`` or n entries. ``observer`` is called with every `Event`; False stops. Other
        threads of Python go on meanwhile, and Ctrl-C ends the iteration.
        """
        name, b = _right_hand_side(rhs)
        return Solution._of(self._core.solve(_asked(rhs=name, **settings), b, observer))

    def set_up(self, *, observer: Observer | None = None, **settings: Unpack[Settings]) -> Solver:
        """Everything that does not depend on a right-hand side; settings as of `solve`."""
        return Solver(self._core.set_up(_asked(**settings), observer))

    def spectrum(
        self,
        preconditioner: Any = "racp",
        augmentation: Any = None,
        inner: Any = None,
        *,
        dense_limit: int | None = None,
        observer: Observer | None = None,
    ) -> Spectrum:
        """Eigenvalues of M⁻¹𝒜 with the region that is proved for them; above ``dense_limit`` unknowns the outer ones alone.

        >>> import fracas
        >>> found = fracas.Scene.gallery("patch").system().spectrum("racp:published")
        >>> found.contained
        True
        """
        asked = _asked(preconditioner, augmentation, inner)
        return Spectrum._of(self._core.spectrum(asked, dense_limit, observer))

    @property
    def operator(self) -> Operator:
        """𝒜 as scipy.sparse.linalg.LinearOperator."""
        _convert.sparse()
        from ._operators import Operator

        return Operator(self._core.operator())

    def preconditioner(self, preconditioner: Any = "racp", augmentation: Any = None, inner: Any = "auto") -> Preconditioner:
        """M⁻¹ as scipy.sparse.linalg.LinearOperator, in the units of the system."""
        _convert.sparse()
        from ._operators import Preconditioner

        return Preconditioner(self._core.preconditioner(_asked(preconditioner, augmentation, inner)))

    def __repr__(self) -> str:
        return f"<fracas.System n_u = {self.n_u}, n_t = {self.n_t}, n_p = {self.n_p}>"


def _path(name: str, value: Any) -> str:
    try:
        path = os.fspath(value)
    except TypeError as error:
        raise WrongType(f"{name}: expected a path, not {kind(value)}") from error
    if not isinstance(path, str):
        raise WrongType(f"{name}: expected a path of text, not {kind(value)}")
    return path


__all__ = ["Observer", "Part", "Settings", "Solution", "Solver", "Spectrum", "System", "SystemInputError"]
