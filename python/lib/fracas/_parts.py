"""Parts that Python brings: a C, a preconditioner, an inner solver."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from . import _core
from ._convert import Vector, kind, matrix, numbers, rows, text, vector
from ._errors import InputError, WrongType

if TYPE_CHECKING:
    from ._system import System

#: A part by name, by settings, or as an object.
PartLike = Any


def _function(what: str, solver: Any) -> Callable[[Any], Any]:
    """`r -> M⁻¹ r` of a function, of a LinearOperator (`matvec`), or of factors (`solve`)."""
    if callable(getattr(solver, "matvec", None)):
        apply = solver.matvec
    elif callable(getattr(solver, "solve", None)):
        apply = solver.solve
    elif callable(solver):
        apply = solver
    else:
        raise WrongType(f"{what}: expected a function of r, or an object with matvec or solve, not {kind(solver)}")
    name = f"{what}: M⁻¹r"

    def wrapped(r: Vector) -> Vector:
        return vector(name, apply(r), r.size)

    return wrapped


def _c_of(value: Any, n_t: int) -> tuple[str, Any]:
    """C as diagonal, blocks, dense or sparse matrix."""
    if hasattr(value, "tocsr"):
        found = rows("C", value)
        if found[:2] != (n_t, n_t):
            raise InputError(f"C is {found[0]} x {found[1]}, expected {n_t} x {n_t}")
        c = matrix(found)
        if c.nnz and (abs(c - c.T) > 1e-12 * abs(c).max()).nnz:
            raise InputError("C is not symmetric")
        return "sparse", found
    array = numbers("C", value)
    if array.shape == (n_t,):
        return "diagonal", array
    if array.ndim == 3 and array.shape == (n_t // 3, 3, 3) and n_t % 3 == 0:
        sizes = np.abs(array).max(axis=(1, 2))
        if (np.abs(array - array.transpose(0, 2, 1)).max(axis=(1, 2)) > 1e-12 * sizes).any():
            raise InputError("a block of C is not symmetric")
        return "faces", array.reshape(-1)
    if array.shape == (n_t, n_t):
        if not np.allclose(array, array.T, rtol=1e-12, atol=1e-12 * float(np.abs(array).max())):
            raise InputError("C is not symmetric")
        return "dense", array
    raise InputError(
        f"C has shape {array.shape}: expected ({n_t},), ({n_t // 3}, 3, 3), ({n_t}, {n_t}) or a sparse matrix of {n_t} x {n_t}"
    )


def _augmentation(c: Any, local: bool = False) -> _core.Part:
    from ._system import System

    def compute(core: _core.System) -> tuple[str, Any]:
        value = c(System._of(core)) if callable(c) else c
        return _c_of(value, core.sizes[1])

    return _core.Part("augmentation", compute, local=local)


def _factory(make: Callable[[System], Any], linear: bool) -> _core.Part:
    from ._system import System

    def prepare(core: _core.System) -> Callable[[Any], Any]:
        return _function("preconditioner", make(System._of(core)))

    return _core.Part("factory", prepare, linear=linear)


def _inner(make: Callable[..., Any], linear: bool) -> _core.Part:
    def prepare(found: Any, coordinates: Any) -> Callable[[Any], Any]:
        return _function("inner", make(matrix(found), coordinates))

    return _core.Part("inner", prepare, linear=linear)


def preconditioner(part: PartLike, linear: bool) -> str | _core.Part:
    """What `preconditioner=` means."""
    if isinstance(part, str):
        return part
    if isinstance(part, dict):
        return text(part)
    if callable(getattr(part, "prepare", None)):
        return _factory(part.prepare, linear)
    return _core.Part("operator", _function("preconditioner", part), linear=linear)


def augmentation(part: PartLike) -> str | _core.Part | None:
    """What `augmentation=` means."""
    if part is None or isinstance(part, str):
        return part
    if isinstance(part, dict) and not hasattr(part, "tocsr"):
        return text(part)
    return _augmentation(part, bool(getattr(part, "is_local", False)))


def inner(part: PartLike, linear: bool) -> str | _core.Part | None:
    """What `inner=` means."""
    if part is None or isinstance(part, str):
        return part
    if isinstance(part, dict):
        return text(part)
    if not callable(part):
        raise WrongType(f"inner: expected a name, settings, or a function of (S, coordinates), not {kind(part)}")
    return _inner(part, linear)


def _named(name: str) -> str:
    """A name that commands and scenes can give."""
    if not isinstance(name, str):
        raise WrongType(f"name: expected text, not {kind(name)}")
    if not name.replace("_", "").replace("-", "").isalnum():
        raise InputError(f"name = {name!r}: expected letters, digits, _ and -")
    return name


def register_augmentation(name: str, c: Callable[[System], Any], *, local: bool = False) -> None:
    """Makes a C known by its name, to scenes, studies and every call from here on.

    ``c(system)`` returns C for the blocks of a system: n_t entries of a diagonal, blocks (n_t/3, 3, 3), a full matrix or a sparse one,
    symmetric positive definite, in the units of BᵀA⁻¹B. ``local=True`` says that C of a face needs A on the supports of that face's
    columns of B alone; runs without an assembled A then ask for it piece by piece.
    """
    _core.register(_named(name), _augmentation(c, local))


def register_preconditioner(name: str, make: Callable[[System], Any], *, linear: bool = True) -> None:
    """Makes a preconditioner known by its name; ``make(system)`` returns M⁻¹ as a function of r, or as an object with ``matvec`` or
    ``solve``. ``linear=False`` says that M⁻¹ changes from call to call: FGMRES is then taken."""
    _core.register(_named(name), _factory(make, linear))


def register_inner(name: str, make: Callable[..., Any], *, linear: bool = True) -> None:
    """Makes an inner solver known by its name; ``make(S, coordinates)`` gets a scipy.sparse matrix, symmetric positive definite, and where
    its unknowns live (n × 4: x, y, z, component; or None), and returns S⁻¹ as a function of r, or as an object with ``matvec`` or
    ``solve``."""
    _core.register(_named(name), _inner(make, linear))
