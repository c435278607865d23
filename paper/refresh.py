#!/usr/bin/env python3
"""Computes the data of the manuscript again and compiles it: `python paper/refresh.py [ID …]`.

Runs `fracas reproduce ID --level paper` for every experiment that has data, or for the named ones, collects what it wrote, and
notes in data/origin.json the commit, the machine and the seconds of each. One experiment that fails leaves its old data and the
exit status 1. Needs `pip install typst`.
"""

import json
import platform
import subprocess
import sys
import time
from pathlib import Path

import build
import collect

ROOT = Path(__file__).resolve().parent.parent
OUT = ROOT / "out" / "paper"
ORIGIN = collect.DATA / "origin.json"


def machine() -> str:
    cpu = platform.processor() or platform.machine()
    info = Path("/proc/cpuinfo")
    if info.exists():
        names = [line.split(":", 1)[1].strip() for line in info.read_text().splitlines() if line.startswith("model name")]
        cpu = f"{names[0]}, {len(names)} cores" if names else cpu
    return f"{cpu}, {platform.system()}"


def commit() -> str:
    def git(*arguments: str) -> str:
        return subprocess.run(["git", *arguments], cwd=ROOT, capture_output=True, text=True, check=True).stdout.strip()

    # The data that this program writes are no change of the program.
    changed = git("status", "--porcelain", "--untracked-files=no", "--", ".", ":!paper")
    return git("rev-parse", "--short=10", "HEAD") + (" with changes" if changed else "")


def main() -> None:
    wanted = sys.argv[1:] or json.loads((collect.DATA / "index.json").read_text())["experiments"]
    subprocess.run(["cargo", "build", "--release"], cwd=ROOT, check=True)
    origin = json.loads(ORIGIN.read_text()) if ORIGIN.exists() else {}
    failed = []
    for name in wanted:
        begun = time.monotonic()
        command = ["target/release/fracas", "reproduce", name, "--level", "paper", "--out", str(OUT)]
        if subprocess.run(command, cwd=ROOT).returncode != 0:
            failed.append(name)
            continue
        seconds = round(time.monotonic() - begun)
        collect.collect(OUT / name)
        origin[name] = {"commit": commit(), "machine": machine(), "seconds": seconds}
        ORIGIN.write_text(json.dumps(dict(sorted(origin.items())), indent=2) + "\n")
    collect.write_index()
    sys.argv[1:] = []
    build.main()
    if failed:
        sys.exit("old data are kept of: " + ", ".join(failed))


if __name__ == "__main__":
    main()
