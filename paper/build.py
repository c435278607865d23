#!/usr/bin/env python3
"""Compiles paper/main.typ: `python paper/build.py [OUT.pdf]`, with `--png DIR` also one image a page (needs `pip install typst`)."""

import argparse
from pathlib import Path

import typst

HERE = Path(__file__).resolve().parent


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("pdf", nargs="?", type=Path, default=HERE / "main.pdf")
    parser.add_argument("--png", type=Path, help="folder for one image a page")
    arguments = parser.parse_args()
    main_file = str(HERE / "main.typ")
    typst.compile(main_file, output=str(arguments.pdf), root=str(HERE))
    print(arguments.pdf)
    if arguments.png:
        arguments.png.mkdir(parents=True, exist_ok=True)
        pages = str(arguments.png / "page-{0p}.png")
        typst.compile(main_file, output=pages, root=str(HERE), format="png", ppi=110)
        print(arguments.png)


if __name__ == "__main__":
    main()
