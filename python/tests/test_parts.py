"""Parts that Python brings enter our iteration, laboratory and runs."""

from __future__ import annotations

import gc
import sys

import numpy as np
import pytest
import scipy.sparse as sp
from conftest import laplacian, random_blocks
from scipy.sparse.linalg import splu

import fracas


def crossing():
    return fracas.Scene.gallery("crossing:small").system()


FORMS = {
    "diagonal": lambda c: c.diagonal(),
    "dense": lambda c: c.toarray(),
    "sparse": lambda c: c,
    "faces": lambda c: np.stack([c.toarray()[3 * f : 3 * f + 3, 3 * f : 3 * f + 3] for f in range(c.shape[0] // 3)]),
}


@pytest.mark.parametrize("form", FORMS)
def test_a_c_of_ours_that_takes_the_way_through_python_does_the_same(form):
    system = crossing()
    name = "fitted_h" if form != "diagonal" else "local"
    c = FORMS[form](system.augmentation(name))
    # H is not relaxed beside a full matrix, which serves theory
    expected = system.solve(preconditioner="racp:published" if form == "dense" else "racp", augmentation=name)
    seen = []

    def rule(of):
        seen.append(of)
        return c

    for given in (c, rule):
        found = system.solve(augmentation=given)
        assert found.converged and abs(found.iterations - expected.iterations) <= (1 if form in ("dense", "sparse") else 0), (form, found.iterations)
        assert np.allclose(found.u, expected.u, atol=1e-6 * np.abs(expected.u).max())
    assert isinstance(seen[0], fracas.System) and seen[0].n == system.n


def test_a_worse_c_takes_more_and_a_better_one_fewer_iterations():
    system = crossing()
    counts = {s: system.solve(augmentation=s * system.augmentation("local").diagonal()).iterations for s in (1.0, 100.0)}
    assert counts[100.0] > counts[1.0]


def test_the_laboratory_takes_a_c_of_python():
    system = crossing()
    c = system.augmentation("local_h").diagonal()
    mine = system.spectrum("racp:published", augmentation=lambda of: c)
    ours = system.spectrum("racp:published", augmentation="local_h")
    assert mine.contained is True and mine.interval == pytest.approx(ours.interval, rel=1e-9)
    assert mine.report["augmentation"] == "python"


def test_a_preconditioner_of_python_in_every_form():
    A, B1, H, _, rhs = random_blocks(11)
    system = fracas.System(A, B1, H=H, rhs=rhs)
    matrix = system.assembled().tocsc()
    factors = splu(matrix)
    calls = []

    class Method:
        def prepare(self, of):
            assert of.n == system.n
            return splu(of.assembled().tocsc())

    def function(r):
        calls.append(r.size)
        return factors.solve(r)

    for given in (function, factors, Method(), system.preconditioner("direct")):
        solution = system.solve(preconditioner=given, tol=1e-10)
        assert solution.converged and solution.iterations <= 2
        assert np.allclose(solution.x, factors.solve(rhs), atol=1e-8)
    assert calls and set(calls) == {system.n}
    plain = system.solve(preconditioner=lambda r: r, measure="residual", max_iterations=500, krylov="gmres:200")
    assert plain.converged and plain.iterations > 5


def test_a_preconditioner_keeps_its_units_in_a_scene():
    scene = fracas.Scene.gallery("crossing:small")
    system = scene.system()
    assert system.traction_unit != 1.0
    ours = system.solve(inner="exact")
    mine = system.solve(preconditioner=system.preconditioner(inner="exact"))
    assert mine.converged and mine.iterations == ours.iterations
    assert scene.solve(preconditioner=system.preconditioner(inner="exact")).iterations == ours.iterations


def test_an_inner_solver_of_python():
    system = crossing()
    seen = []

    def exact(S, coordinates):
        seen.append((S.shape, None if coordinates is None else coordinates.shape))
        return splu(S.tocsc())

    mine, ours = system.solve(inner=exact), system.solve(inner="exact")
    assert seen == [((system.n_u, system.n_u), (system.n_u, 4))]
    assert mine.converged and mine.iterations == ours.iterations

    def changing(S, _):
        rng, d = np.random.default_rng(0), S.diagonal()
        return lambda r: r / d * rng.uniform(0.9, 1.1)

    flexible = system.solve(inner=changing, linear=False, measure="residual", max_iterations=2000)
    assert flexible.report["krylov"].startswith("fgmres")
    with pytest.raises(fracas.InputError, match="linear preconditioner"):
        system.solve(inner=changing, linear=False, krylov="minres")


def test_registered_parts_are_known_everywhere():
    fracas.register_augmentation("half_local", lambda of: 0.5 * of.augmentation("local").diagonal(), local=False)
    fracas.register_inner("their_lu", lambda S, _: splu(S.tocsc()))
    fracas.register_preconditioner("their_direct", lambda of: splu(of.assembled().tocsc()))
    scene = fracas.Scene.gallery("crossing:small")
    assert scene.solve(augmentation="half_local", inner="their_lu").converged
    assert scene.solve(preconditioner="their_direct").iterations <= 2
    expected = [step.slip.max() for step in fracas.Scene.gallery("cycle:small").run()]
    mine = fracas.Scene.gallery(
        "cycle:small", {"solver.racp.augmentation": "half_local", "solver.racp.inner": "their_lu"}
    )
    found = [step.slip.max() for step in mine.run()]
    assert np.allclose(found, expected, rtol=1e-5, atol=1e-5 * max(expected))
    with pytest.raises(fracas.InputError, match="half_local"):
        fracas.register_augmentation("half_local", lambda of: 1.0)


@pytest.mark.parametrize(
    "settings",
    [
        {"preconditioner": lambda r: 1 / 0},
        {"augmentation": lambda of: 1 / 0},
        {"inner": lambda S, x: 1 / 0},
        {"inner": lambda S, x: lambda r: 1 / 0},
        {"observer": lambda event: 1 / 0},
    ],
)
def test_what_python_raises_inside_comes_out(settings):
    system = crossing()
    with pytest.raises(ZeroDivisionError):
        system.solve(**settings)
    assert system.solve().converged, "and nothing is left of it"


def test_an_observer_hears_and_stops():
    A, B = laplacian(30, 40)
    system = fracas.System(A, B, rhs=np.ones(A.shape[0] + 40))
    heard = []
    settings = {"inner": "jacobi", "measure": "residual", "max_iterations": 500}
    solution = system.solve(observer=heard.append, **settings)
    residuals = [event.residual for event in heard if event.kind == "krylov"]
    assert residuals == list(solution.history[:, 1]) and len(residuals) > 10
    assert any(event.kind == "line" and "iterating" in event.text for event in heard)
    stopped = system.solve(observer=lambda event: event.kind != "krylov" or event.iteration < 5, **settings)
    assert stopped.outcome == "stopped" and stopped.iterations <= 6


def test_parts_are_let_go():
    system = crossing()
    c = system.augmentation("local").diagonal()
    inverse = system.preconditioner("direct")

    def rule(of):
        return c

    before = sys.getrefcount(rule), sys.getrefcount(inverse)
    for _ in range(20):
        system.solve(augmentation=rule)
        system.solve(preconditioner=inverse)
        kept = system.set_up(augmentation=rule)
    del kept
    gc.collect()
    assert (sys.getrefcount(rule), sys.getrefcount(inverse)) == before


def test_several_threads_solve_at_once():
    from concurrent.futures import ThreadPoolExecutor

    blocks = [random_blocks(seed) for seed in range(300, 312)]
    systems = [fracas.System(A, B1, H=H, B2=B2, rhs=rhs) for A, B1, H, B2, rhs in blocks]
    alone = [system.solve(augmentation=lambda of: sp.eye_array(of.n_t).tocsr()).x for system in systems]
    with ThreadPoolExecutor(4) as pool:
        together = list(pool.map(lambda s: s.solve(augmentation=lambda of: sp.eye_array(of.n_t).tocsr()).x, systems))
    assert all(np.array_equal(x, y) for x, y in zip(alone, together, strict=True))
