"""𝒜 and M⁻¹ as scipy.sparse.linalg.LinearOperator."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.sparse.linalg import LinearOperator

from . import _core
from ._convert import vector


class _Linear(LinearOperator):  # type: ignore[misc]
    """A product of the extension module; ``matvec`` of a contiguous vector of f64 takes no detour."""

    def __init__(self, core: Any):
        self._core = core
        super().__init__(np.dtype(np.float64), (core.size, core.size))

    def matvec(self, x: Any) -> Any:
        """The product with a vector, of shape (n,) or (n, 1)."""
        if type(x) is np.ndarray and x.ndim == 1 and x.dtype == np.float64 and x.flags.c_contiguous and x.flags.aligned:
            return self._core.apply(x)
        return super().matvec(x)

    def _matvec(self, x: Any) -> Any:
        return self._core.apply(vector("x", x, self.shape[1]))

    @property
    def flops(self) -> int:
        """Floating-point operations of one product."""
        return int(self._core.flops)


class Operator(_Linear):
    """𝒜 = [A B1; B2 −H] in the units of the system.

    >>> import fracas
    >>> system = fracas.Scene.gallery("patch").system()
    >>> system.operator.shape == (system.n, system.n)
    True
    """

    _core: _core.Operator

    def _rmatvec(self, x: Any) -> Any:
        return self._core.apply_adjoint(vector("x", x, self.shape[0]))


class Preconditioner(_Linear):
    """M⁻¹ in the units of the system, ready to be applied.

    It is its own adjoint where ``is_symmetric``: RACP of a symmetric 𝒜.
    """

    _core: _core.Preconditioner

    def _rmatvec(self, x: Any) -> Any:
        if not self.is_symmetric:
            raise NotImplementedError(f"{self.name}: the adjoint of this M⁻¹ is not known")
        return self._core.apply(vector("x", x, self.shape[0]))

    @property
    def name(self) -> str:
        """The method with its inner solver."""
        return self._core.name

    @property
    def is_linear(self) -> bool:
        """False where it depends on r other than linearly: take FGMRES."""
        return self._core.is_linear

    @property
    def is_single(self) -> bool:
        """True where it is rounded to 32 bits inside: linear to seven digits."""
        return self._core.is_single

    @property
    def is_symmetric(self) -> bool:
        """True where it is its own adjoint."""
        return self._core.is_symmetric

    def __repr__(self) -> str:
        return f"<{self.shape[0]}x{self.shape[1]} M⁻¹: {self.name}>"
