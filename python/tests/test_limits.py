"""Time, memory, locks, signals, types."""

from __future__ import annotations

import importlib.util
import os
import signal
import subprocess
import sys
import textwrap
import threading
import time
from pathlib import Path

import numpy as np
import pytest
from conftest import ROOT, laplacian

import fracas

#: Largest time of a product beside that of the product itself [s]; five microseconds is what the package promises.
OVERHEAD = 5e-6


def resident_kib() -> int:
    with open("/proc/self/statm") as statm:
        return int(statm.read().split()[1]) * os.sysconf("SC_PAGE_SIZE") // 1024


@pytest.mark.skipif(not os.path.exists("/proc/self/statm"), reason="memory is read from /proc")
def test_a_thousand_solves_take_no_more_memory_than_a_hundred():
    A, B = laplacian(12, 8)
    c = np.ones(8)

    def solves(times):
        for _ in range(times):
            system = fracas.System(A, B, rhs=np.ones(A.shape[0] + 8))
            assert system.solve(augmentation=lambda of: c).converged
            assert system.solve(preconditioner=system.preconditioner()).converged

    solves(100)
    before = resident_kib()
    solves(1000)
    assert resident_kib() - before < 4 * 1024


def test_the_overhead_of_a_product_is_small():
    A, B = laplacian(4, 2)
    operator = fracas.System(A, B).operator
    x = np.ones(operator.shape[0])
    best = min(_seconds(lambda: operator.matvec(x)) for _ in range(20))
    print(f"a product of {x.size} unknowns takes {best * 1e6:.2f} microseconds in all")
    assert best < OVERHEAD


def _seconds(work, times=2000):
    begin = time.perf_counter()
    for _ in range(times):
        work()
    return (time.perf_counter() - begin) / times


def test_other_threads_go_on_while_a_system_is_solved():
    system = fracas.Scene.gallery("layered_crossing", {f"mesh.{a}.cells": 24 for a in "xyz"}).system()
    ended, counted = threading.Event(), []

    def count():
        while not ended.is_set():
            counted.append(time.perf_counter())
            time.sleep(0.002)

    thread = threading.Thread(target=count)
    thread.start()
    begin = time.perf_counter()
    assert system.solve(inner="amg").converged
    took = time.perf_counter() - begin
    ended.set()
    thread.join()
    gaps = np.diff([t for t in counted if t >= begin])
    assert took > 0.1 and len(gaps) > 0.2 * took / 0.002
    assert gaps.max() < 0.5 * took


@pytest.mark.parametrize(
    "work",
    [
        "fracas.Scene.gallery('layered_crossing', {f'mesh.{a}.cells': 48 for a in 'xyz'}).solve(inner='jacobi', tol=1e-12, observer=say)",
        "list(fracas.Scene.gallery('cycle', {f'mesh.{a}.cells': 40 for a in 'xyz'}).run('out', observer=say))",
        "fracas.study({'title': 'Long', 'axes': {'scene': ['cycle:small'], 'refine': list(range(1, 9))}}, 'out', observer=lambda *_: say(None))",
    ],
)
def test_ctrl_c_ends_a_solve_a_run_and_a_study(work, tmp_path):
    program = f"""
        import fracas, sys
        def say(event):
            if event is None or event.kind == "krylov":
                print("begun", flush=True)
        try:
            {work}
        except KeyboardInterrupt:
            sys.exit(7)
    """
    command = [sys.executable, "-c", textwrap.dedent(program)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, cwd=tmp_path) as process:
        assert process.stdout is not None and process.stdout.readline() == b"begun\n"
        process.send_signal(signal.SIGINT)
        begin = time.perf_counter()
        process.stdout.read()
        assert process.wait(timeout=60) == 7
    print(f"ended {time.perf_counter() - begin:.2f} s later")


def test_answers_do_not_depend_on_threads():
    program = """
        import fracas, sys
        fracas.set_threads(int(sys.argv[1]))
        solution = fracas.Scene.gallery("layered_crossing:small").solve(inner="amg")
        sys.stdout.buffer.write(solution.x.tobytes())
    """
    command = [sys.executable, "-c", textwrap.dedent(program)]
    answers = {subprocess.run([*command, str(n)], capture_output=True, check=True).stdout for n in (1, 3)}
    assert len(answers) == 1


USER = '''
from collections.abc import Iterator
import numpy as np
import fracas

def counts(name: str) -> Iterator[int]:
    system: fracas.System = fracas.Scene.gallery(name).system()
    for c in ("local", "fitted_h"):
        solution = system.solve(augmentation=c, tol=1e-8)
        yield solution.iterations
    error: float | None = solution.error_u
    largest: float = max(float(np.abs(step.traction).max()) for step in fracas.Scene.gallery(name).run(steps=2))
    found: fracas.Spectrum = system.spectrum("racp:published")
    bounds: tuple[float, float] | None = found.interval
    print(error, largest, bounds, system.operator.flops)
'''


@pytest.mark.skipif(importlib.util.find_spec("mypy") is None, reason="mypy is not installed: stubs are not checked")
def test_stubs_serve_a_strict_user_and_describe_the_module(tmp_path):
    (tmp_path / "user.py").write_text(USER)
    # scipy has no stubs of its own
    command = [sys.executable, "-m", "mypy", "--strict", "--config-file", str(ROOT / "python" / "pyproject.toml")]
    package = str(Path(fracas.__file__).parents[1])
    installed = {} if "site-packages" in package else {"MYPYPATH": package}
    environment = {**os.environ, **installed}
    done = subprocess.run([*command, "user.py"], cwd=tmp_path, capture_output=True, text=True, env=environment)
    assert done.returncode == 0, done.stdout
    (tmp_path / "user.py").write_text(USER.replace("solution.iterations", "solution.iteration"))
    done = subprocess.run([*command, "user.py"], cwd=tmp_path, capture_output=True, text=True, env=environment)
    assert done.returncode == 1 and "iteration" in done.stdout
    (tmp_path / "user.py").write_text(USER.replace("tol=1e-8", "tolerance=1e-8"))
    done = subprocess.run([*command, "user.py"], cwd=tmp_path, capture_output=True, text=True, env=environment)
    assert done.returncode == 1 and "tolerance" in done.stdout
    own = subprocess.run(command, cwd=ROOT / "python", capture_output=True, text=True)
    assert own.returncode == 0, own.stdout
    from fracas import _core

    stub = (ROOT / "python" / "lib" / "fracas" / "_core.pyi").read_text()
    for name in dir(_core):
        public = not name.startswith("_")
        assert not public or f"class {name}:" in stub or f"def {name}(" in stub or f"{name}:" in stub, name
