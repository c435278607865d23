"""Studies from files and dictionaries."""

from __future__ import annotations

import pytest
from conftest import bytes_of

import fracas

FILE = """title = "Two methods"
question = "Which one?"
clock = false
[axes]
scene = ["clamped:small"]
method = ["racp", "mcp"]
inner = ["exact", "amg"]
"""

TABLE = {
    "title": "Two methods",
    "question": "Which one?",
    "clock": False,
    "axes": {"scene": ["clamped:small"], "method": ["racp", "mcp"], "inner": ["exact", "amg"]},
}


def test_a_study_leaves_the_bytes_of_the_program(tmp_path, command):
    (tmp_path / "study.toml").write_text(FILE)
    command("study", tmp_path / "study.toml", "--out", tmp_path / "theirs")
    told = []
    found = fracas.study(tmp_path / "study.toml", tmp_path / "ours", observer=lambda *row: told.append(row))
    assert (found.done, found.total, found.holds) == (4, 4, True)
    assert [row[0] for row in told] == [1, 2, 3, 4]
    theirs, ours = bytes_of(tmp_path / "theirs"), bytes_of(tmp_path / "ours")
    assert set(theirs) == set(ours)
    assert [name for name in theirs if theirs[name] != ours[name] and name != "manifest.json"] == []
    again = fracas.study(tmp_path / "study.toml", tmp_path / "ours")
    assert again.rows == found.rows
    of_table = fracas.study(TABLE, tmp_path / "table")
    assert of_table.column("n_it") == found.column("n_it")
    assert all(isinstance(n, int) for n in found.column("n_it"))
    with pytest.raises(fracas.InputError, match="no column"):
        found.column("n_iter")


def test_an_exception_of_the_observer_ends_a_study(tmp_path):
    def observer(*_):
        raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        fracas.study(TABLE, tmp_path / "out", observer=observer)
    assert fracas.study(TABLE, tmp_path / "out").done == 4, "it goes on where it stopped"
