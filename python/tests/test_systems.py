"""Systems from scipy: answers, blocks, folders."""

from __future__ import annotations

import json

import numpy as np
import pytest
import scipy.sparse as sp
from conftest import laplacian, random_blocks, whole
from scipy.sparse.linalg import spsolve

import fracas


@pytest.mark.parametrize("seed", range(30))
def test_random_systems_have_the_solution_of_spsolve(seed):
    A, B1, H, B2, rhs = random_blocks(seed)
    system = fracas.System(A, B1, H=H, B2=B2, rhs=rhs)
    expected = spsolve(whole(A, B1, H, B2), rhs)
    solution = system.solve(tol=1e-11, measure="residual")
    assert solution.converged, solution.reason
    assert np.linalg.norm(solution.x - expected) < 1e-7 * np.linalg.norm(expected)
    assert np.array_equal(solution.x, np.r_[solution.u, solution.t, solution.p])
    residual = np.linalg.norm(rhs - system.operator @ solution.x) / np.linalg.norm(rhs)
    assert residual == pytest.approx(solution.relative_residual, rel=1e-3, abs=1e-15)


@pytest.mark.parametrize("method", ["racp", "mcp", "direct", "augmented_lagrangian", "block_triangular", "simple", "racp:published"])
def test_every_method_finds_the_same(method):
    A, B1, H, _, rhs = random_blocks(7)
    system = fracas.System(A, B1, H=H, rhs=rhs)
    expected = spsolve(whole(A, B1, H, None), rhs)
    solution = system.solve(preconditioner=method, tol=1e-10)
    assert solution.converged, solution.reason
    assert np.linalg.norm(solution.x - expected) < 1e-6 * np.linalg.norm(expected)


@pytest.mark.parametrize("krylov", ["gmres", "gmres:20", "fgmres", "bicgstab"])
@pytest.mark.parametrize("inner", ["exact", "amg", "ssor", {"fsai": {}}])
def test_parts_are_named_or_set(krylov, inner):
    A, B = laplacian(20, 12)
    system = fracas.System(A, B, rhs=np.ones(A.shape[0] + 12))
    solution = system.solve(inner=inner, krylov=krylov, augmentation="local")
    assert solution.converged
    # multigrid in f32 takes the flexible kind
    flexible = "f" * (inner == "amg" and krylov.startswith("gmres")) + krylov
    assert solution.report["krylov"].startswith(flexible)
    assert solution.report["augmentation"] == "local"


def test_blocks_come_back_as_they_went_in_and_share_memory():
    A, B1, H, B2, rhs = random_blocks(4)
    coordinates = np.column_stack([np.random.default_rng(0).random((A.shape[0], 3)), np.arange(A.shape[0]) % 3])
    system = fracas.System(A, B1, H=H, B2=B2, rhs=rhs, coordinates=coordinates)
    for name, given in [("A", A), ("B1", B1), ("H", H), ("B2", B1.T if B2 is None else B2)]:
        found = getattr(system, name)
        if given is None:
            assert found is None
            continue
        assert (found != given).nnz == 0
    assert np.array_equal(system.rhs, rhs) and np.array_equal(system.coordinates, coordinates)
    first, second = system.A, system.A
    assert np.shares_memory(first.data, second.data) and np.shares_memory(first.indices, second.indices)
    with pytest.raises(ValueError, match="read-only"):
        first.data[0] = 1.0
    kept = system.A
    values = kept.data.copy()
    del system, first, second
    assert np.array_equal(kept.data, values), "the matrix keeps what it shows alive"
    assert (fracas.System(A, B1, H=H, B2=B2).assembled() != whole(A, B1, H, B2).tocsr()).nnz == 0


def test_matrices_that_share_show_the_memory_of_the_library():
    A, B1, H, _, rhs = random_blocks(4)
    before = A.copy()
    system = fracas.System(A, B1, H=H, rhs=rhs, share=True)
    assert (A != before).nnz == 0
    assert np.shares_memory(A.data, system.A.data) and np.shares_memory(A.indices, system.A.indices)
    assert not A.data.flags.writeable and np.allclose(A @ np.ones(A.shape[0]), before @ np.ones(A.shape[0]))
    other = before.tocsc()
    assert (fracas.System(other, B1, share=True).A != before).nnz == 0 and other.data.flags.writeable


def test_formats_kinds_and_duplicates_are_converted():
    A, B = laplacian(8, 4)
    expected = fracas.System(A, B).A
    coo = sp.coo_array(
        (np.r_[0.25 * A.tocoo().data, 0.75 * A.tocoo().data], (np.r_[A.tocoo().row, A.tocoo().row], np.r_[A.tocoo().col, A.tocoo().col])),
        shape=A.shape,
    )
    wide = A.copy()
    wide.indices, wide.indptr = wide.indices.astype(np.int64), wide.indptr.astype(np.int64)
    for given in (A.tocsc(), A.toarray(), A.astype(np.float32), A.astype(int), sp.lil_matrix(A), coo, wide):
        assert (fracas.System(given, B).A != expected).nnz == 0


def test_a_folder_is_the_same_system_for_python_and_for_the_program(tmp_path, command):
    A, B = laplacian(15, 9)
    system = fracas.System(A, B, rhs=np.arange(A.shape[0] + 9.0))
    system.write(tmp_path / "mine")
    back = fracas.System.read(tmp_path / "mine")
    assert (back.A != system.A).nnz == 0 and np.array_equal(back.rhs, system.rhs)
    command("solve", "--system", tmp_path / "mine", "--json", tmp_path / "out.json", "--solution", tmp_path / "x.mtx")
    report = json.loads((tmp_path / "out.json").read_text())
    solution = back.solve()
    assert solution.iterations == report["iterations"]
    assert solution.report["traction_unit"] == report["traction_unit"] == 4.0
    x = np.loadtxt(tmp_path / "x.mtx", comments="%", skiprows=2)
    assert np.array_equal(solution.x, x)


def test_an_export_is_solved_as_the_program_solves_it(tmp_path, command):
    command("export", "crossing:small", "--out", tmp_path / "theirs")
    scene = fracas.Scene.gallery("crossing:small")
    scene.system().write(tmp_path / "ours")
    for name in ("A.mtx", "B1.mtx", "H.mtx", "rhs_u.mtx", "coords.mtx", "manifest.json"):
        assert (tmp_path / "theirs" / name).read_bytes() == (tmp_path / "ours" / name).read_bytes()
    command("solve", "--system", tmp_path / "theirs", "--json", tmp_path / "out.json")
    report = json.loads((tmp_path / "out.json").read_text())
    for solution in (fracas.System.read(tmp_path / "theirs").solve(), scene.system().solve()):
        assert solution.iterations == report["iterations"]
        assert solution.report["traction_unit"] == report["traction_unit"]
        assert solution.error_t == report["error_t"]
    command("solve", "crossing:small", "--json", tmp_path / "scene.json")
    report = json.loads((tmp_path / "scene.json").read_text())
    assert scene.solve().error_t == report["error_t"]


def test_a_solver_takes_many_right_hand_sides():
    A, B = laplacian(20, 12)
    system = fracas.System(A, B, rhs=np.ones(A.shape[0] + 12))
    solver = system.set_up(tol=1e-11, measure="residual")
    rng = np.random.default_rng(3)
    for _ in range(3):
        b = rng.standard_normal(system.n)
        assert np.allclose(system.operator @ solver.solve(b).x, b, atol=1e-8)
    assert np.allclose(system.operator @ system.solve(rhs="ones", tol=1e-11).x, 1.0, atol=1e-8)
    assert np.allclose(system.operator @ system.solve(rhs=b, tol=1e-11).x, b, atol=1e-7)


def test_the_spectrum_lies_where_it_is_proved():
    system = fracas.Scene.gallery("crossing", {"mesh.x.cells": 8, "mesh.y.cells": 2, "mesh.z.cells": 8}).system()
    found = system.spectrum("racp:published", inner="ssor")
    assert found.contained is True
    low, high = found.interval
    real = found.eigenvalues[np.abs(found.eigenvalues.imag) < 1e-7].real
    assert low <= real.min() * (1 + 1e-7) and real.max() <= high * (1 + 1e-7)
    assert {part.kind for part in found.region} >= {"interval"}
    dense = np.linalg.eigvals(np.linalg.solve(np.eye(system.n), (system.preconditioner("racp:published", inner="ssor") @ system.operator @ np.eye(system.n))))
    assert np.allclose(np.sort(dense.real), np.sort(found.eigenvalues.real), atol=1e-6)


def test_flow_blocks_are_taken():
    rng = np.random.default_rng(5)
    A, B1, _, _, _ = random_blocks(5)
    n_u, n_t, n_p = A.shape[0], B1.shape[1], 4
    q = 0.1 * sp.random_array((n_u, n_p), density=0.4, rng=rng)
    T = sp.diags_array(rng.uniform(1.0, 2.0, n_p))
    rhs = rng.standard_normal(n_u + n_t + n_p)
    system = fracas.System(A, B1, flow=(q, -q.T, T), rhs=rhs)
    expected = spsolve(system.assembled().tocsc(), rhs)
    solution = system.solve(tol=1e-11)
    assert solution.converged and solution.p.size == n_p
    assert np.allclose(solution.x, expected, atol=1e-7)
