from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._convert import Rows, Vector

__version__: str
has_suitesparse: bool

class Event:
    """What an iteration reports."""

    #: ``krylov``, ``newton``, ``round``, ``progress`` or ``line``.
    kind: str
    #: Iterations, Newton steps, rounds or parts so far.
    iteration: int
    #: Relative residual of krylov and newton.
    residual: float | None
    #: Faces that take another state, of a round.
    changed: int | None
    #: Parts in all, of a progress.
    total: int | None
    #: Stage of a progress, or the line.
    text: str | None

class Part:
    def __new__(cls, family: str, f: Callable[..., Any], *, linear: bool = True, local: bool = False) -> Part: ...

class Matrix:
    def rows(self) -> tuple[Any, ...]: ...

class System:
    def __new__(
        cls,
        a: Rows,
        b1: Rows,
        b2: Rows | None,
        h: Rows | None,
        flow: Any,
        rhs: Vector | None,
        places: Any,
    ) -> System: ...
    @staticmethod
    def read(path: str) -> System: ...
    def write(self, path: str) -> None: ...
    sizes: tuple[int, int, int]
    is_ours: bool
    has_rhs: bool
    findings: list[str]
    rhs: Vector
    coordinates: Any
    traction_unit: float
    def block(self, name: str) -> tuple[Any, ...] | None: ...
    def in_traction_unit(self, unit: float) -> System: ...
    def augmentation(self, name: str) -> Matrix: ...
    def solve(
        self, asked: dict[str, Any], b: Vector | None = None, observer: Any = None
    ) -> tuple[str, Vector, NDArray[np.uint64], Vector]: ...
    def set_up(self, asked: dict[str, Any], observer: Any = None) -> Solver: ...
    def spectrum(self, asked: dict[str, Any], dense_limit: int | None, observer: Any = None) -> str: ...
    def operator(self) -> Operator: ...
    def preconditioner(self, asked: dict[str, Any]) -> Preconditioner: ...

class Solver:
    unknowns: int
    setup_s: float
    def solve(
        self, b: Vector | None = None, observer: Any = None
    ) -> tuple[str, Vector, NDArray[np.uint64], Vector]: ...

class Operator:
    size: int
    flops: int
    def apply(self, x: Vector) -> Vector: ...
    def apply_adjoint(self, x: Vector) -> Vector: ...

class Preconditioner:
    size: int
    flops: int
    name: str
    is_linear: bool
    is_single: bool
    is_symmetric: bool
    def apply(self, r: Vector) -> Vector: ...

class Scene:
    @staticmethod
    def from_toml(text: str, name: str) -> Scene: ...
    @staticmethod
    def load(name: str) -> Scene: ...
    def with_overrides(self, overrides: list[str]) -> Scene: ...
    def to_toml(self) -> str: ...
    title: str
    name: str
    nodes: int
    def mesh(self) -> dict[str, Any]: ...
    def system(self, stabilization: float, observer: Any) -> System: ...
    def solve(
        self, asked: dict[str, Any], stabilization: float, b: Vector | None = None, observer: Any = None
    ) -> tuple[str, Vector, NDArray[np.uint64], Vector]: ...
    def set_up(self, asked: dict[str, Any], stabilization: float, observer: Any = None) -> Solver: ...
    def spectrum(
        self, asked: dict[str, Any], stabilization: float, dense_limit: int | None, observer: Any = None
    ) -> str: ...
    def run(
        self,
        out: str | None,
        restart: str | None,
        steps: int | None,
        fields_every: int,
        clock: bool,
        fields: bool,
        observer: Any = None,
    ) -> Steps: ...

class Steps:
    HEADING: str
    ended: tuple[str, str | None, str | None]
    def advance(self, observer: Any = None) -> dict[str, Any] | None: ...
    def close(self) -> None: ...

def register(name: str, part: Part) -> None: ...
def gallery() -> list[tuple[str, str]]: ...
def study(
    text: str | None,
    name: str,
    folder: str,
    out: str,
    jobs: int,
    level: str | None = None,
    tell: Any = None,
) -> tuple[int, int, bool]: ...
def set_threads(n: int) -> None:
    """Works on so many threads from here on; results do not depend on it."""
