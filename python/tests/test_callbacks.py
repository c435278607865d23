"""Calls within calls: nothing hangs, nothing stays behind, nothing comes out elsewhere. What could hang runs in a process of its own."""

import gc
import subprocess
import sys
import threading
import time
import weakref

import numpy as np
import pytest
import scipy.sparse as sp

import fracas


def alone(code):
    """Runs code in a process that may take a minute."""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    return done.stdout.split()


def system(n=25):
    a = sp.diags([-1.0, 2.0, -1.0], [-1, 0, 1], shape=(n, n), format="csr")
    b = sp.csr_array(([1.0, -1.0], ([2, 3], [0, 0])), shape=(n, 1))
    return fracas.System(a, b, rhs=np.ones(n + 1))


def test_runs_that_wait_hold_no_thread_that_others_need():
    told = alone(
        """
import fracas
fracas.set_threads(1)
scene = fracas.Scene.gallery("patch:small")
runs = [scene.run() for _ in range(3)]
steps = [next(run).step for run in runs]
within = []
def mine(r):
    within.append(scene.solve().converged)
    return r
scene.system().solve(preconditioner=mine, max_iterations=2)
print(steps, len(within) > 0 and all(within))
"""
    )
    assert told == ["[0,", "0,", "0]", "True"]


def test_a_run_is_closed_by_its_observer_and_not_asked_for_a_step_by_it():
    told = alone(
        """
import fracas
scene = fracas.Scene.gallery("cycle:small")
def hear(event):
    if not said:
        said.append(run.outcome)
        try:
            next(run)
        except fracas.InputError:
            said.append("refused")
        run.close()
said = []
run = scene.run(observer=hear)
steps = list(run)
print(*said, len(steps), run.outcome)
"""
    )
    assert told == ["running", "refused", "0", "interrupted"]


def test_a_solver_at_work_refuses_another_solution_and_goes_on():
    told = alone(
        """
import fracas
solver = fracas.Scene.gallery("patch:small").system().set_up()
refused = []
def hear(event):
    try:
        solver.solve()
    except fracas.InputError:
        refused.append(True)
print(solver.solve(observer=hear).converged, len(refused) > 0, solver.solve().converged)
"""
    )
    assert told == ["True", "True", "True"]


@pytest.mark.parametrize("threads", ["", "fracas.set_threads(1)"])
def test_what_is_called_by_what_an_observer_calls_is_within_it_too(threads):
    told = alone(
        f"""
import fracas
{threads}
patch = fracas.Scene.gallery("patch:small")
solver = patch.system().set_up()
refused = []
def asks(what):
    def hear(event):
        if len(refused) < 9:
            try:
                what()
            except fracas.InputError:
                refused.append(True)
    return hear
def solve(event):
    patch.solve(observer=asks(solver.solve))
print(solver.solve(observer=solve).converged, len(refused))
refused.clear()
def step(event):
    patch.solve(observer=asks(lambda: next(run)))
run = fracas.Scene.gallery("cycle:small").run(observer=step)
print(next(run).step, len(refused))
"""
    )
    assert told == ["True", "9", "0", "9"]


@pytest.mark.parametrize("threads", ["", "fracas.set_threads(1)"])
def test_a_run_may_be_closed_while_its_folder_is_opened(tmp_path, threads):
    told = alone(
        f"""
import fracas
{threads}
def hear(event):
    if event.kind == "line" and runs:
        runs[0].close()
runs = []
run = fracas.Scene.gallery("patch:small").run({str(tmp_path / "o")!r}, observer=hear)
runs.append(run)
steps = list(run)
run.close()
print(len(steps) <= 2, run.outcome in ("interrupted", "finished"))
"""
    )
    assert told == ["True", "True"]


def test_a_run_does_not_go_on_in_a_child():
    told = alone(
        """
import os, fracas
run = fracas.Scene.gallery("cycle:small").run()
next(run)
child = os.fork()
if child == 0:
    try:
        next(run)
    except fracas.RunError:
        os._exit(0)
    os._exit(1)
print(os.waitpid(child, 0)[1], next(run).step)
"""
    )
    assert told == ["0", "1"]


def test_a_forked_child_has_threads_of_its_own():
    told = alone(
        """
import os, fracas
scene = fracas.Scene.gallery("patch:small")
run = scene.run()
next(run)
print(scene.solve().converged, flush=True)
child = os.fork()
if child == 0:
    os._exit(0 if scene.solve().converged else 1)
print(os.waitpid(child, 0)[1])
"""
    )
    assert told == ["True", "0"]


def test_deep_recursion_in_a_callback_is_an_exception():
    told = alone(
        """
import fracas
def deep(n):
    return sorted([n], key=lambda _: deep(n + 1))
def mine(r):
    deep(0)
    return r
try:
    fracas.Scene.gallery("patch:small").system().solve(preconditioner=mine)
except RecursionError:
    print("raised")
"""
    )
    assert told == ["raised"]


def registered(name, raises):
    """An inner solver that raises while `raises` has something."""

    def make(s, _):
        solve = sp.linalg.splu(s.tocsc()).solve

        def inverse(r):
            if raises:
                raise raises[0]
            return solve(r)

        return inverse

    fracas.register_inner(name, make)


def test_what_a_registered_part_raises_ends_its_call_and_no_other():
    raises = [ZeroDivisionError("mine")]
    registered("mine_that_raises", raises)
    scene = fracas.Scene.gallery("cycle:small", {"solver.racp.inner": "mine_that_raises"})
    run = scene.run(steps=1)
    with pytest.raises(ZeroDivisionError):
        list(run)
    assert run.outcome == "failed" and "mine" in run.reason
    assert system().solve().converged
    raises.clear()
    with scene.run() as run:
        assert next(run).step == 0


def test_what_a_part_raises_in_one_thread_does_not_come_out_in_another():
    raises = [KeyError("mine")]
    registered("mine_of_one_thread", raises)
    patch = fracas.Scene.gallery("patch:small").system()
    seen = []

    def other():
        for _ in range(40):
            seen.append(patch.solve().converged)

    thread = threading.Thread(target=other)
    thread.start()
    for _ in range(40):
        with pytest.raises(KeyError):
            patch.solve(inner="mine_of_one_thread", augmentation="local")
    thread.join()
    assert seen == [True] * 40


def test_a_run_that_ends_by_an_exception_says_so():
    def hear(event):
        raise LookupError("mine")

    run = fracas.Scene.gallery("cycle:small").run(observer=hear)
    with pytest.raises(LookupError):
        next(run)
    assert run.outcome in ("interrupted", "failed")
    assert list(run) == []


def test_who_holds_a_run_and_observes_it_is_let_go():
    class Watcher:
        def __init__(self):
            self.seen = 0
            self.run = fracas.Scene.gallery("patch:small").run(observer=self.hear)

        def hear(self, event):
            self.seen += 1

    alive = []
    for _ in range(5):
        watcher = Watcher()
        next(watcher.run)
        assert watcher.seen > 0
        alive.append(weakref.ref(watcher))
        del watcher
    # the thread of a run lets its observer go once it has told the step
    for _ in range(100):
        gc.collect()
        if not any(held() for held in alive):
            return
        time.sleep(0.05)
    raise AssertionError("somebody holds a run and its observer")


def test_a_right_hand_side_of_zeros_is_one():
    zero = fracas.System(system().A, system().B1, rhs=np.zeros(26))
    assert not zero.solve().x.any() and zero.solve().converged
    assert not zero.set_up().solve().x.any()
    assert fracas.System(system().A, system().B1).solve().x.any()


def test_a_preconditioner_that_is_zero_does_not_converge():
    for settings in ({}, {"linear": False}, {"measure": "residual"}):
        assert not system().solve(preconditioner=lambda r: 0.0 * r, **settings).converged


def test_every_form_of_c_is_the_same_c_where_a_is_singular():
    patch = fracas.Scene.gallery("patch").system().in_traction_unit()
    c = sp.csr_array(patch.augmentation("local"))
    d = c.diagonal()
    assert abs(c - sp.diags_array(d)).max() == 0.0
    forms = [d, c, c.toarray(), sp.diags(d), sp.diags_array(d), sp.dok_array(c), sp.coo_array(c), sp.bsr_array(c)]
    counts = [patch.solve(augmentation=form, inner="exact") for form in forms]
    assert all(found.converged for found in counts)
    # factors of other forms round otherwise
    assert max(found.iterations for found in counts) <= min(found.iterations for found in counts) + 2


def test_rows_that_do_not_count_are_an_exception():
    a = system().A.copy()
    for place, value in ((3, 10**6), (3, -1), (0, 1), (-1, 10**6)):
        bad = a.copy()
        bad.indptr = bad.indptr.copy()
        bad.indptr[place] = value
        with pytest.raises(fracas.SystemInputError, match="indptr"):
            fracas.System(bad, system().B1)


def test_a_scene_counts_in_the_units_of_its_blocks_for_parts_of_ones_own():
    scene = fracas.Scene.gallery("crossing:small")
    blocks = scene.system()

    def mine(of):
        return of.augmentation("local")

    whole = scene.set_up(augmentation=mine, inner="exact").solve()
    assert whole.iterations == blocks.set_up(augmentation=mine, inner="exact").solve().iterations


def test_digests_are_text(tmp_path):
    columns = {"digest": ["7030085600169338", "6076635212e02019"], "n": ["3", ""], "tol": ["1e-8", "0.5"], "scene": ["12", "a"]}
    values = {name: fracas._study._values(name, cells) for name, cells in columns.items()}
    assert values == {"digest": columns["digest"], "n": [3, None], "tol": [1e-8, 0.5], "scene": ["12", "a"]}


def test_blocks_of_c_may_be_rounded_and_vectors_lie_anywhere():
    patch = fracas.Scene.gallery("crossing:small").system()
    draw = np.random.default_rng(5)
    faces = patch.n_t // 3
    turns, _ = np.linalg.qr(draw.normal(size=(faces, 3, 3)))
    blocks = turns @ (draw.uniform(1e-9, 1e-3, size=(faces, 3))[:, :, None] * turns.transpose(0, 2, 1))
    patch.preconditioner(augmentation=blocks)
    shifted = np.ndarray(patch.n, np.float64, bytearray(8 * patch.n + 1), offset=1)
    shifted[:] = 1.0
    assert (patch.operator @ shifted == patch.operator @ np.ones(patch.n)).all()


def test_an_inner_solver_of_ones_own_is_not_taken_for_symmetric():
    patch = fracas.Scene.gallery("crossing:small").system()
    assert patch.preconditioner(inner="exact").is_symmetric

    def lower(s, _):
        triangle = sp.tril(s, format="csr")
        return lambda r: sp.linalg.spsolve_triangular(triangle, r, lower=True)

    assert not patch.preconditioner(inner=lower).is_symmetric


def test_names_and_texts_that_no_scene_could_hold():
    for name in ("", " ", "{x", "a b"):
        with pytest.raises(fracas.InputError):
            fracas.register_inner(name, lambda s, x: None)
    assert fracas._convert.toml({"title": "a\x7fb"}, "scene") == 'title = "a\\u007fb"\n'
