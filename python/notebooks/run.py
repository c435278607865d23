"""Runs notebooks cell by cell, as Jupyter would, without Jupyter: `python run.py [--write] NOTEBOOK…`.

A cell that raises ends the run with its notebook, number and source. `--write` puts what cells print and draw back into the file.
"""

from __future__ import annotations

import ast
import base64
import contextlib
import io
import json
import sys
import traceback
from pathlib import Path
from typing import Any


def cell(source: str, names: dict[str, Any]) -> list[dict[str, Any]]:
    """Runs a cell: what it prints, the value of its last line, its figures."""
    tree = ast.parse(source)
    last = tree.body.pop() if tree.body and isinstance(tree.body[-1], ast.Expr) else None
    printed, outputs = io.StringIO(), []
    with contextlib.redirect_stdout(printed):
        exec(compile(tree, "<cell>", "exec"), names)
        value = None if last is None else eval(compile(ast.Expression(last.value), "<cell>", "eval"), names)
    text = printed.getvalue() + ("" if value is None else f"{value!r}\n")
    if text:
        outputs.append({"output_type": "stream", "name": "stdout", "text": text.splitlines(keepends=True)})
    pyplot = sys.modules.get("matplotlib.pyplot")
    for number in pyplot.get_fignums() if pyplot else []:
        image = io.BytesIO()
        pyplot.figure(number).savefig(image, format="png", dpi=72, metadata={"Software": None})
        data = {"image/png": base64.b64encode(image.getvalue()).decode()}
        outputs.append({"output_type": "display_data", "metadata": {}, "data": data})
    if pyplot:
        pyplot.close("all")
    return outputs


def run(path: Path, write: bool = False) -> None:
    """Every cell of a notebook, in one name space."""
    notebook = json.loads(path.read_text(encoding="utf-8"))
    names: dict[str, Any] = {"__name__": "__main__"}
    for number, part in enumerate(notebook["cells"]):
        if part["cell_type"] != "code":
            continue
        source = "".join(part["source"])
        try:
            part["outputs"] = cell(source, names)
        except Exception as error:
            raise SystemExit(f"{path.name}, cell {number}:\n{source}\n{traceback.format_exc()}") from error
    if write:
        path.write_text(json.dumps(notebook, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")


if __name__ == "__main__":
    files = [name for name in sys.argv[1:] if name != "--write"]
    for name in files:
        run(Path(name), "--write" in sys.argv)
