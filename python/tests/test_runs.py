"""Runs: the files of the program, fields, restarts, ends."""

from __future__ import annotations

import csv
import json
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from conftest import bytes_of

import fracas


@pytest.mark.parametrize("scene", ["cycle:small", "injection:small"])
def test_a_run_leaves_the_bytes_of_the_program(scene, tmp_path, command):
    command("run", scene, "--out", tmp_path / "theirs", "--steps", 6)
    run = fracas.Scene.gallery(scene).run(tmp_path / "ours", steps=6)
    steps = list(run)
    assert run.outcome == "stopped" and run.folder == tmp_path / "ours" and len(steps) == 6
    theirs, ours = bytes_of(tmp_path / "theirs"), bytes_of(tmp_path / "ours")
    for files in (theirs, ours):
        # the high-water mark of a process is its own
        kept = [line for line in files["run.json"].splitlines() if b"peak_memory_bytes" not in line]
        files["run.json"] = b"".join(kept)
    assert set(theirs) == set(ours) and len(theirs) > 20
    assert [name for name in theirs if theirs[name] != ours[name]] == []
    with open(tmp_path / "theirs" / "history.csv", newline="") as lines:
        for row, step in zip(csv.DictReader(lines), steps, strict=True):
            assert {name: float(text) for name, text in row.items() if text} == step.row


def test_without_a_folder_steps_are_the_same(tmp_path):
    scene = fracas.Scene.gallery("cycle:small")
    in_memory, in_folder = scene.run(steps=8), scene.run(tmp_path / "out", steps=8)
    for mine, theirs in zip(in_memory, in_folder, strict=True):
        assert mine.row == theirs.row
        assert np.array_equal(mine.displacement, theirs.displacement)
        assert np.array_equal(mine.traction, theirs.traction)
    assert in_memory.folder is None and in_memory.outcome == "stopped"


def test_fields_have_shapes_and_obey_coulomb():
    scene = fracas.Scene.gallery("cycle:small")
    mesh, seen = scene.mesh(), set()
    assert mesh.elements.shape[1] == 8 and mesh.elements.max() < len(mesh.nodes)
    assert np.array_equal(mesh.nodes[mesh.faces_minus], mesh.nodes[mesh.faces_plus])
    assert np.allclose(np.linalg.det(mesh.frames), 1.0)
    for step in scene.run():
        k = len(mesh.areas)
        assert step.displacement.shape == mesh.nodes.shape and step.traction.shape == (k, 3) and step.state.shape == (k,)
        open_ = step.state == 3
        assert np.all(step.traction[open_] == 0.0) and np.all(step.traction[~open_, 0] < 1.0)
        shear = np.linalg.norm(step.traction[:, 1:], axis=1)
        assert np.all(shear <= step.tau_limit * (1 + 1e-6) + 1.0)
        sides = step.displacement[mesh.faces_plus] - step.displacement[mesh.faces_minus]
        normal = np.einsum("kai,ki->k", sides, mesh.frames[:, 0]) / 4
        assert np.allclose(normal, step.jump[:, 0], atol=1e-9 + 1e-6 * np.abs(step.jump).max())
        assert np.bincount(step.state, minlength=4).tolist() == [step.row[s] for s in ("stick", "newslip", "slip", "open")]
        seen |= set(step.state.tolist())
    assert {0, 2, 3} <= seen


def test_a_run_goes_on_where_it_was_left(tmp_path):
    scene = fracas.Scene.gallery("cycle:small")
    whole = [step.row for step in scene.run(tmp_path / "whole")]
    with scene.run(tmp_path / "parts") as run:
        first = [next(run).row for _ in range(4)]
    assert run.outcome == "interrupted"
    assert json.loads((tmp_path / "parts" / "run.json").read_text())["outcome"] == "interrupted"
    rest = [step.row for step in scene.run(restart=tmp_path / "parts")]
    assert first + rest == whole
    assert (tmp_path / "whole" / "history.csv").read_bytes() == (tmp_path / "parts" / "history.csv").read_bytes()


def test_a_run_that_is_forgotten_leaves_a_whole_folder(tmp_path):
    scene = fracas.Scene.gallery("cycle:small")
    run = scene.run(tmp_path / "out")
    next(run)
    del run
    assert json.loads((tmp_path / "out" / "run.json").read_text())["outcome"] == "interrupted"
    assert not (tmp_path / "out" / ".lock").exists()
    assert len(list(scene.run(restart=tmp_path / "out"))) > 3
    with pytest.raises(fracas.RunError, match="out"):
        next(scene.run(tmp_path / "out"))


def test_a_run_that_is_open_where_python_ends_leaves_a_whole_folder(tmp_path):
    program = "import fracas; run = fracas.Scene.gallery('cycle:small').run('out'); next(run)"
    subprocess.run([sys.executable, "-c", program], cwd=tmp_path, check=True, timeout=60)
    assert json.loads((tmp_path / "out" / "run.json").read_text())["outcome"] == "interrupted"


def test_two_threads_may_ask_the_same_run():
    run = fracas.Scene.gallery("cycle:small").run(observer=lambda event: None)
    with ThreadPoolExecutor(2) as pool:
        taken = list(pool.map(lambda _: [step.step for step in run], range(2)))
    assert sorted(taken[0] + taken[1]) == list(range(len(taken[0]) + len(taken[1]))) and run.outcome == "finished"


def test_a_step_that_does_not_converge_is_an_exception(tmp_path):
    scene = fracas.Scene.gallery("cycle:small", {"solver.max_newton": 1, "solver.max_cuts": 0, "solver.max_active": 1})
    run = scene.run(tmp_path / "out")
    with pytest.raises(fracas.NotConverged):
        list(run)
    assert run.outcome == "not_converged" and run.reason
    assert (tmp_path / "out" / "report.html").is_file()


def test_an_observer_stops_a_run():
    rounds = []
    run = fracas.Scene.gallery("cycle:small").run(observer=lambda e: e.kind != "round" or rounds.append(e.changed) or len(rounds) < 6)
    assert 0 < len(list(run)) < 12 and run.outcome == "interrupted" and len(rounds) == 6


def test_scenes_come_from_files_text_and_dictionaries(tmp_path):
    import tomllib

    scene = fracas.Scene.gallery("cycle:small")
    text = scene.to_toml()
    (tmp_path / "mine.toml").write_text(text)
    again = [
        fracas.Scene.from_file(tmp_path / "mine.toml"),
        fracas.Scene.from_toml(text),
        fracas.Scene.from_dict(tomllib.loads(text)),
    ]
    assert all(other.to_toml() == text for other in again)
    for name in fracas.gallery():
        whole = fracas.Scene.gallery(name).to_toml()
        assert fracas.Scene.from_dict(tomllib.loads(whole)).to_toml() == whole
    assert fracas.Scene.gallery("cycle", {"mesh.x.cells": np.int64(9)}).to_toml() != fracas.Scene.gallery("cycle").to_toml()
