"""Whatever cannot be is an exception that names it, and never a panic."""

from __future__ import annotations

import datetime

import numpy as np
import pytest
import scipy.sparse as sp
from conftest import laplacian

import fracas

A, B = laplacian(6, 3)
N = A.shape[0]


def spoiled(matrix, row, column, value):
    table = matrix.toarray()
    table[row, column] = value
    return sp.csr_array(table)


WRONG_SYSTEMS = [
    ((A[:-1], B), {}, "B1|A|square", ValueError),
    ((A, B[:-1]), {}, "B1", ValueError),
    ((A, B), {"H": np.eye(4)}, "H", ValueError),
    ((A, B), {"B2": B}, "B2", ValueError),
    ((spoiled(A, 2, 3, np.nan), B), {}, "A: it holds NaN at row 3, column 4", ValueError),
    ((A, spoiled(B, 1, 2, np.inf)), {}, "B1: it holds inf at row 2, column 3", ValueError),
    ((spoiled(A, 0, 5, 1.0), B), {}, "A is not symmetric|A.*symmetric", ValueError),
    (("A", B), {}, "A: expected a scipy.sparse matrix or a 2-D array, not a str", TypeError),
    ((None, B), {}, "A: expected", TypeError),
    ((A.astype(complex), B), {}, "A: expected real entries .float64., not complex128", TypeError),
    ((A.toarray().astype(object), B), {}, "A: expected real numbers .float64., not an array of object", TypeError),
    ((np.ones(N), B), {}, "A: expected a matrix, not shape", ValueError),
    ((sp.csr_array((0, 0)), sp.csr_array((0, 0))), {}, "A is 0", ValueError),
    ((A, B), {"rhs": np.ones(3)}, "rhs: expected a vector of 39 entries, not shape .3,.", ValueError),
    ((A, B), {"rhs": np.full(N + 3, np.nan)}, "rhs holds NaN at entry 0", ValueError),
    ((A, B), {"rhs": "sin"}, "rhs: expected real numbers", TypeError),
    ((A, B), {"rhs": [[1, 2], [3]]}, "rhs: expected numbers", TypeError),
    ((A, B), {"coordinates": np.ones((5, 3))}, "coordinates: expected 36 rows", ValueError),
    ((A, B), {"coordinates": np.full((N, 4), 7.0)}, "component 7 in row 0", ValueError),
    ((A, B), {"coordinates": np.full((N // 3, 3), np.inf)}, "coordinates: row 0", ValueError),
    ((A, B), {"flow": (A, B)}, "flow: expected", TypeError),
    ((A, B), {"flow": (B, B, np.eye(3))}, "Q2", ValueError),
]


@pytest.mark.parametrize("number", range(len(WRONG_SYSTEMS)))
def test_systems(number):
    matrices, more, sentence, family = WRONG_SYSTEMS[number]
    with pytest.raises(fracas.Error, match=sentence) as raised:
        fracas.System(*matrices, **more)
    assert isinstance(raised.value, family)


WRONG_SETTINGS = [
    ({"preconditioner": "rcap"}, "unknown method .rcap.: expected racp, mcp", fracas.InputError),
    ({"preconditioner": {"racp": {"innr": "amg"}}}, "innr", fracas.InputError),
    ({"preconditioner": 3}, "preconditioner: expected a function", fracas.WrongType),
    ({"preconditioner": "direct", "augmentation": "local"}, "direct has no augmentation C", fracas.InputError),
    ({"augmentation": "locl"}, "unknown augmentation .locl.: expected local", fracas.InputError),
    ({"augmentation": np.ones(2)}, "C has shape .2,.", fracas.InputError),
    ({"augmentation": -np.ones(3)}, "C is not positive definite", fracas.SetupError),
    ({"augmentation": np.array([[1.0, 2.0, 0], [0, 1, 0], [0, 0, 1]])}, "C is not symmetric", fracas.InputError),
    ({"augmentation": datetime.date.today()}, "C: expected", fracas.WrongType),
    ({"inner": "agm"}, "agm", fracas.InputError),
    ({"inner": "geometric"}, "geometric", fracas.InputError),
    ({"inner": 2.0}, "inner: expected", fracas.WrongType),
    ({"krylov": "gmers"}, "gmers", fracas.InputError),
    ({"krylov": 50}, "krylov: expected", fracas.WrongType),
    ({"tol": 0.0}, "the tolerance is a number between 0 and 1, not 0", fracas.InputError),
    ({"tol": "small"}, "tol: expected a number, not a str", fracas.WrongType),
    ({"tol": float("nan")}, "tolerance", fracas.InputError),
    ({"measure": "norm"}, "unknown measure", fracas.InputError),
    ({"max_iterations": -1}, "max_iterations", fracas.InputError),
    ({"traction_unit": -2.0}, "unit of tractions", fracas.InputError),
    ({"rhs": "cos"}, "unknown rhs", fracas.InputError),
    ({"rhs": np.ones(2)}, "rhs has 2 entries, expected 39", fracas.InputError),
    ({"rhs": 1j * np.ones(39)}, "rhs: expected real numbers .float64., not an array of complex128", fracas.WrongType),
    ({"preconditioner": lambda r: r[:2]}, "M⁻¹r: expected a vector of 39 entries, not shape", fracas.InputError),
    ({"preconditioner": lambda r: r * np.nan}, "M⁻¹r holds NaN at entry 0", fracas.InputError),
    ({"preconditioner": lambda r: "r"}, "M⁻¹r: expected", fracas.WrongType),
]


@pytest.mark.parametrize("number", range(len(WRONG_SETTINGS)))
def test_settings(number):
    settings, sentence, kind = WRONG_SETTINGS[number]
    system = fracas.System(A, B, rhs=np.ones(N + 3))
    with pytest.raises(kind, match=sentence):
        system.solve(**settings)


def test_a_misspelt_setting_is_python_s_own_error():
    with pytest.raises(TypeError, match="tolerance"):
        fracas.System(A, B).solve(tolerance=1e-8)


@pytest.mark.parametrize("x", [np.ones(3), np.ones((3, 3)), np.ones(N + 3, dtype=complex), "x", None])
def test_products(x):
    system = fracas.System(A, B)
    with pytest.raises((ValueError, TypeError)):
        system.operator.matvec(x)
    with pytest.raises((ValueError, TypeError)):
        system.preconditioner().matvec(x)


def test_products_of_strided_and_integer_vectors():
    system = fracas.System(A, B)
    n = system.n
    x = np.arange(2.0 * n)[::2]
    assert np.array_equal(system.operator @ x, system.operator @ x.copy())
    assert np.array_equal(system.operator @ np.arange(n), system.operator @ np.arange(float(n)))
    assert np.array_equal(system.operator @ np.eye(n), system.assembled().toarray())


SCENES = [
    (lambda: fracas.Scene.gallery("crosing"), "did you mean `crossing`"),
    (lambda: fracas.Scene.gallery(3), "name: expected the name of a scene, not a int"),
    (lambda: fracas.Scene.from_file("nowhere.toml"), "cannot read nowhere.toml"),
    (lambda: fracas.Scene.from_file(3), "path: expected a path, not a int"),
    (lambda: fracas.Scene.from_toml("title = "), "scene.toml:1"),
    (lambda: fracas.Scene.from_toml(b"x"), "text: expected TOML as text, not a bytes"),
    (lambda: fracas.Scene.from_dict({"titel": "x"}), "did you mean `title`"),
    (lambda: fracas.Scene.from_dict([1]), "sections: expected a dictionary, not a list"),
    (lambda: fracas.Scene.from_dict({"title": None}), "title is a NoneType"),
    (lambda: fracas.Scene.from_dict({3: "x"}), "keys are strings, not a int"),
    (lambda: fracas.Scene.gallery("cycle", {"mesh.x.cell": 3}), "cell"),
    (lambda: fracas.Scene.gallery("cycle", {"mesh.x.cells": object()}), "mesh.x.cells is a object"),
    (lambda: fracas.Scene.gallery("cycle", ["mesh.x.cells=3"]), "overrides: expected a dictionary"),
    (lambda: fracas.Scene.gallery("cycle:small").system(stabilization=-1.0), "stabilization = -1"),
    (lambda: fracas.Scene.gallery("cycle:small").run(steps=0), "steps = 0"),
    (lambda: fracas.Scene.gallery("cycle:small").run(out=7), "out: expected a path"),
    (lambda: next(fracas.Scene.gallery("clamped:small").run()), "friction"),
    (lambda: fracas.System.read("/nowhere"), "/nowhere is not a folder"),
    (lambda: fracas.System.read(None), "folder: expected a path, not a NoneType"),
    (lambda: fracas.study({"title": "x"}, "/tmp/none"), "axes"),
    (lambda: fracas.study(7, "/tmp/none"), "file: expected a path"),
    (lambda: fracas.study("nowhere.toml", "/tmp/none"), "nowhere.toml"),
    (lambda: fracas.set_threads(0), "threads = 0"),
    (lambda: fracas.register_augmentation("local", lambda s: s), "local"),
    (lambda: fracas.register_inner("auto", lambda s, x: s), "auto"),
]


@pytest.mark.parametrize("number", range(len(SCENES)))
def test_scenes_runs_and_studies(number):
    work, sentence = SCENES[number]
    with pytest.raises(fracas.Error, match=sentence):
        work()


def test_a_system_that_cannot_be_solved_says_which_block():
    singular = sp.csr_array((N, N))
    with pytest.raises(fracas.Error):
        fracas.System(singular, B, rhs=np.ones(N + 3)).solve()


def test_not_converging_is_a_value():
    solution = fracas.System(A, B, rhs=np.ones(N + 3)).solve(augmentation="global", inner="jacobi", max_iterations=2)
    assert solution.outcome == "iteration_limit" and not solution.converged and solution.iterations == 2
