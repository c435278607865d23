"""𝒜 and M⁻¹ as LinearOperators, in iterations of scipy."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse as sp
from conftest import laplacian, random_blocks, whole
from scipy.sparse.linalg import LinearOperator, aslinearoperator, bicgstab, eigs, gmres

import fracas


@pytest.mark.parametrize("seed", range(20))
def test_products_are_those_of_the_assembled_matrix(seed):
    A, B1, H, B2, _ = random_blocks(100 + seed)
    system = fracas.System(A, B1, H=H, B2=B2)
    operator, matrix = system.operator, whole(A, B1, H, B2)
    assert isinstance(operator, LinearOperator) and operator.shape == matrix.shape and operator.dtype == np.float64
    rng = np.random.default_rng(seed)
    x, y = rng.standard_normal((2, system.n))
    scale = abs(matrix).max() * np.abs(x).sum()
    assert np.abs(operator @ x - matrix @ x).max() < 1e-14 * scale
    assert np.abs(operator.rmatvec(x) - matrix.T @ x).max() < 1e-14 * scale
    assert (operator @ x) @ y == pytest.approx(x @ operator.rmatvec(y), rel=1e-11, abs=1e-12 * scale)
    assert np.array_equal((operator @ np.c_[x, y])[:, 1], operator @ y)
    assert operator.matvec(x[:, None]).shape == (system.n, 1)
    assert operator.flops > 0


@pytest.mark.parametrize("inner", ["exact", "ssor", "fsai", "amg"])
@pytest.mark.parametrize("seed", range(4))
def test_a_preconditioner_is_linear_and_its_own_adjoint(inner, seed):
    A, B1, H, _, _ = random_blocks(200 + seed)
    inverse = fracas.System(A, B1, H=H).preconditioner(inner=inner)
    x, y = np.random.default_rng(seed).standard_normal((2, inverse.shape[0]))
    exact = 1e-4 if inverse.is_single else 1e-9
    z = inverse @ (x + 3.0 * y)
    assert np.allclose(z, inverse @ x + 3.0 * (inverse @ y), rtol=0.0, atol=exact * np.abs(z).max())
    assert inverse.is_linear and inverse.is_symmetric
    bound = exact * np.linalg.norm(inverse @ x) * np.linalg.norm(y)
    assert abs((inverse @ x) @ y - x @ inverse.rmatvec(y)) < bound
    assert "racp" in inverse.name and "racp" in repr(inverse)


def test_an_adjoint_that_is_not_known_is_no_wrong_one():
    A, B1, H, _, _ = random_blocks(3)
    inverse = fracas.System(A, B1, H=H).preconditioner("block_triangular")
    with pytest.raises(NotImplementedError, match="block_triangular"):
        inverse.rmatvec(np.ones(inverse.shape[0]))


@pytest.mark.parametrize("scene", ["crossing:small", "cycle:small", "floating:small", "layered:small"])
@pytest.mark.parametrize("inner", ["exact", "ssor"])
def test_gmres_of_scipy_takes_our_count(scene, inner):
    system = fracas.Scene.gallery(scene).system().in_traction_unit()
    ours = system.solve(inner=inner, measure="residual", tol=1e-8, krylov="gmres:400")
    assert ours.converged
    counted = []
    inverse = system.preconditioner(inner=inner)
    right = system.operator @ inverse
    y, _ = gmres(right, system.rhs, rtol=1e-8, atol=0.0, restart=400, maxiter=1, callback=counted.append, callback_type="pr_norm")
    assert abs(len(counted) - ours.iterations) <= 1
    x = inverse @ y
    assert np.linalg.norm(system.rhs - system.operator @ x) < 1.1e-8 * np.linalg.norm(system.rhs)
    if not scene.startswith("layered"):
        # from the left, as its argument M takes it: a contrast of 1000 leaves its residual short of 1e-8
        _, status = gmres(system.operator, system.rhs, M=inverse, rtol=1e-8, restart=400, maxiter=2)
        assert status == 0


def test_other_iterations_of_scipy_run_on_racp():
    A, B = laplacian(30, 20)
    system = fracas.System(A, B, rhs=np.ones(A.shape[0] + 20))
    x, status = bicgstab(system.operator, system.rhs, M=system.preconditioner(inner="exact"), rtol=1e-10)
    assert status == 0 and np.linalg.norm(system.operator @ x - system.rhs) < 1e-6 * np.linalg.norm(system.rhs)


def test_eigenvalues_of_scipy_lie_where_ours_do():
    system = fracas.Scene.gallery("crossing:small").system()
    preconditioned = system.preconditioner("racp:published", inner="exact") @ system.operator
    largest = eigs(preconditioned, k=3, which="LM", return_eigenvectors=False, v0=np.ones(system.n))
    found = system.spectrum("racp:published", inner="exact")
    assert abs(largest).max() == pytest.approx(np.abs(found.eigenvalues).max(), rel=1e-6)


def test_operators_of_scipy_and_ours_add_up():
    A, B = laplacian(10, 6)
    system = fracas.System(A, B)
    shifted = system.operator + aslinearoperator(2.0 * sp.eye_array(system.n))
    x = np.arange(float(system.n))
    assert np.allclose(shifted @ x, system.operator @ x + 2.0 * x)
