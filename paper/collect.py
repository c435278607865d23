#!/usr/bin/env python3
"""Refreshes paper/data from the folder that `fracas reproduce all --level paper --out OUT` wrote.

    python paper/collect.py OUT [ID …]

Takes the manifest, the tables (CSV) and the figures (SVG) of every experiment in OUT, or of the named ones, and lists all
experiments present in index.json, from which the manuscript decides which studies to print. Refuses an experiment that was
not run at paper level or with a check that does not hold. Standard library only.
"""

import json
import shutil
import sys
from collections import Counter
from pathlib import Path

DATA = Path(__file__).resolve().parent / "data"


def slim(svg: str) -> str:
    """Drops default attributes, and copies of a mark beyond the fourth: four translucent marks already hide the ground."""
    svg = svg.replace(' opacity="1"', "").replace(' stroke="none"', "")
    copies, lines = Counter(), []
    for line in svg.splitlines():
        if line.endswith("/>"):
            copies[line] += 1
            if copies[line] > 4:
                continue
        lines.append(line)
    return "\n".join(lines) + "\n"


def collect(folder: Path) -> str:
    manifest = json.loads((folder / "manifest.json").read_text())
    name = manifest["id"]
    if manifest["level"] != "paper":
        sys.exit(f"{folder}: level is {manifest['level']}, not paper")
    failed = [check["claim"] for check in manifest["checks"] if not check["pass"]]
    if failed:
        sys.exit(f"{folder}: checks do not hold: " + "; ".join(failed))
    target = DATA / name
    shutil.rmtree(target, ignore_errors=True)
    target.mkdir(parents=True)
    shutil.copy(folder / "manifest.json", target)
    for table in manifest["tables"]:
        shutil.copy(folder / f"{table['id']}.csv", target)
    for figure in manifest["figures"]:
        name_in_text = f"{figure['id']}.column.svg"
        (target / name_in_text).write_text(slim((folder / name_in_text).read_text()))
    return name


def write_index() -> None:
    """Lists what is there, from which the manuscript decides which studies to print."""
    present = sorted(path.parent.name for path in DATA.glob("*/manifest.json"))
    (DATA / "index.json").write_text(json.dumps({"experiments": present}, indent=2) + "\n")


def main() -> None:
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    out, wanted = Path(sys.argv[1]), sys.argv[2:]
    found = sorted(path.parent for path in out.glob("*/manifest.json"))
    if not found:
        sys.exit(f"{out}: no experiment here")
    missing = set(wanted) - {path.name for path in found}
    if missing:
        sys.exit(f"{out}: no {', '.join(sorted(missing))}")
    for folder in found:
        if not wanted or folder.name in wanted:
            print("collected", collect(folder))
    write_index()


if __name__ == "__main__":
    main()
