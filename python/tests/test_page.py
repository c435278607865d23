"""docs/python.md prints what it says; the notebooks run."""

from __future__ import annotations

import doctest
import importlib.util
import os
import subprocess
import sys

import pytest
from conftest import ROOT

NOTEBOOKS = sorted((ROOT / "python" / "notebooks").glob("*.ipynb"))


def test_the_page_prints_what_it_says():
    page = ROOT / "docs" / "python.md"
    found = doctest.testfile(str(page), module_relative=False, optionflags=doctest.ELLIPSIS, encoding="utf-8")
    assert found.attempted > 20 and found.failed == 0


def test_there_are_five_notebooks():
    assert len(NOTEBOOKS) == 5


@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_runs(notebook):
    if importlib.util.find_spec("matplotlib") is None:
        pytest.skip("matplotlib is not installed: notebooks draw with it")
    command = [sys.executable, str(ROOT / "python" / "notebooks" / "run.py"), str(notebook)]
    environment = {**os.environ, "MPLCONFIGDIR": os.environ.get("MPLCONFIGDIR", str(ROOT / "target"))}
    done = subprocess.run(command, capture_output=True, text=True, env=environment)
    assert done.returncode == 0, done.stderr


def test_a_notebook_that_is_wrong_says_where(tmp_path):
    wrong = '{"cells": [{"cell_type": "code", "source": ["x = 1\\n", "assert x == 2"], "outputs": []}]}'
    (tmp_path / "wrong.ipynb").write_text(wrong)
    command = [sys.executable, str(ROOT / "python" / "notebooks" / "run.py"), str(tmp_path / "wrong.ipynb")]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 1 and "wrong.ipynb, cell 0" in done.stderr and "assert x == 2" in done.stderr
