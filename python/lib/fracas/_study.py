"""Studies: a product of scenes, meshes and methods, a row per solve."""

from __future__ import annotations

import csv
import os
import re
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from . import _convert, _core
from ._convert import kind
from ._errors import InputError, WrongType
from ._system import _path


@dataclass(frozen=True)
class Study:
    """What a study found, on the disk in ``folder`` (rows.csv, figures, report.html)."""

    folder: Path
    #: Rows on the disk, and rows of the study.
    done: int
    total: int
    #: False where a check of the file fails.
    holds: bool
    #: Rows as in rows.csv; numbers are numbers.
    rows: list[dict[str, Any]] = field(repr=False)

    def column(self, name: str) -> list[Any]:
        """One column of all rows."""
        known = list(self.rows[0]) if self.rows else []
        if name not in known:
            raise InputError(f"no column {name!r}; there are: {', '.join(known)}")
        return [row[name] for row in self.rows]


_INTEGER = re.compile(r"[+-]?(0|[1-9]\d*)")
_NUMBER = re.compile(r"[+-]?((\d+\.?\d*|\.\d+)([eE][+-]?\d+)?|inf|nan)", re.IGNORECASE)


def _values(name: str, cells: list[str]) -> list[Any]:
    """A column: integers or numbers where all its cells are, else text; None where a cell is empty. A digest is text whatever its digits."""
    written = [cell for cell in cells if cell]
    read: Callable[[str], Any] = str
    if name != "digest":
        if all(_INTEGER.fullmatch(cell) for cell in written):
            read = int
        elif all(_NUMBER.fullmatch(cell) for cell in written):
            read = float
    return [read(cell) if cell else None for cell in cells]


def study(
    file: str | os.PathLike[str] | dict[str, Any],
    out: str | os.PathLike[str],
    *,
    level: str | None = None,
    jobs: int = 1,
    observer: Callable[[int, int, str, str], Any] | None = None,
) -> Study:
    """Solves the rows of a study that ``out`` does not hold yet, as `fracas study` does.

    ``file`` is a path, the name of a study of the gallery (``"e02"``), or a dictionary of the sections of a study file; ``observer(done,
    total, name, outcome)`` hears of every row. Rows that fail are rows, and no exception.
    """
    if not isinstance(jobs, int) or not 1 <= jobs <= 256:
        raise InputError(f"jobs = {jobs!r}: expected 1 to 256")
    folder = _path("out", out)
    text: str | None
    if isinstance(file, dict):
        text, name = _convert.toml(file, "study"), "study"
    elif isinstance(file, (str, os.PathLike)):
        name = _path("file", file)
        text = Path(name).read_text(encoding="utf-8") if os.path.isfile(name) else None
    else:
        raise WrongType(f"file: expected a path, a name or a dictionary, not {kind(file)}")
    parent = os.path.dirname(name) if text is not None and name != "study" else ""
    done, total, holds = _core.study(text, name, parent, folder, jobs, level, observer)
    with open(Path(folder) / "rows.csv", newline="", encoding="utf-8") as lines:
        heading, *table = csv.reader(lines)
    columns = [_values(name, list(cells)) for name, cells in zip(heading, zip(*table))]
    rows = [dict(zip(heading, row)) for row in zip(*columns)]
    return Study(Path(folder), done, total, holds, rows)
