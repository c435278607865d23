"""A system from scipy to its solution, beside `fracas solve` of the same folder: time and peak memory of a process each.

    python python/measure.py 40 [PROGRAM]

40 is the number of cells along an axis of the scene `layered_crossing`, a multiple of 8.
"""

from __future__ import annotations

import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

PROGRAM = Path(__file__).resolve().parents[1] / "target" / "release" / "fracas"


def prepare(folder: Path, cells: int) -> None:
    """The same matrices for both: files of scipy, and a system folder that does not know of fracas."""
    import numpy as np
    import scipy.sparse as sp

    import fracas

    scene = fracas.Scene.gallery("layered_crossing", {f"mesh.{a}.cells": cells for a in "xyz"})
    system = scene.system().in_traction_unit()
    for name in ("A", "B1", "H"):
        sp.save_npz(folder / f"{name}.npz", getattr(system, name).tocsr(), compressed=False)
    np.savez(folder / "vectors.npz", rhs=system.rhs, coordinates=system.coordinates)
    blocks = {name: getattr(system, name) for name in ("A", "B1", "H")}
    fracas.System(**blocks, rhs=system.rhs, coordinates=system.coordinates).write(folder / "system")


def solve(folder: Path) -> None:
    """In Python: the clock starts when the matrices are there."""
    import numpy as np
    import scipy.sparse as sp

    import fracas

    A, B1, H = (sp.load_npz(folder / f"{name}.npz") for name in ("A", "B1", "H"))
    vectors = np.load(folder / "vectors.npz")
    rhs, coordinates = vectors["rhs"], vectors["coordinates"]
    begin = time.perf_counter()
    share = bool(os.environ.get("SHARE"))
    system = fracas.System(A, B1, H=H, rhs=rhs, coordinates=coordinates, share=share)
    taken = time.perf_counter() - begin
    solution = system.solve(inner="amg")
    told = {
        "unknowns": system.n,
        "iterations": solution.iterations,
        "system_s": taken,
        "setup_s": solution.setup_s,
        "solve_s": solution.solve_s,
        "whole_s": time.perf_counter() - begin,
    }
    print(json.dumps(told))


def peak(command: list[str], **more: str) -> tuple[float, float, str]:
    """Wall time [s], peak memory [MB] and output of a process."""
    begin = time.perf_counter()
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env={**os.environ, **more}) as process:
        assert process.stdout is not None
        out = process.stdout.read()
        _, status, used = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    assert process.returncode == 0, command
    return time.perf_counter() - begin, used.ru_maxrss * 1024 / 1e6, out


def main() -> None:
    if sys.argv[1] in ("prepare", "solve"):
        work = {"prepare": lambda f: prepare(f, int(sys.argv[3])), "solve": solve}[sys.argv[1]]
        return work(Path(sys.argv[2]))
    program = sys.argv[2] if len(sys.argv) > 2 else str(PROGRAM)
    with tempfile.TemporaryDirectory() as folder:
        peak([sys.executable, __file__, "prepare", folder, sys.argv[1]])
        report = f"{folder}/report.json"
        for _ in range(2):
            wall, memory, _out = peak([program, "solve", "--system", f"{folder}/system", "--inner", "amg", "--json", report])
            told = json.loads(Path(report).read_text())
            keys = ("iterations", "setup_s", "solve_s")
            print(f"program   {wall:7.2f} s {memory:7.0f} MB", {key: told[key] for key in keys}, flush=True)
            for share in ("", "1"):
                _, memory, out = peak([sys.executable, __file__, "solve", folder], SHARE=share)
                what = "shared " if share else "copied "
                print(f"{what}   {json.loads(out)['whole_s']:7.2f} s {memory:7.0f} MB", out.strip(), flush=True)


if __name__ == "__main__":
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    main()
