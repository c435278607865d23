"""Seeded systems, and the program that Python is held against."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
import scipy.sparse as sp

import fracas

ROOT = Path(__file__).resolve().parents[2]


def random_blocks(seed: int):
    """A, B1, H, B2, rhs of a random system: A symmetric positive definite, H semi-definite or none, B2 = B1ᵀ or near it."""
    rng = np.random.default_rng(seed)
    n_u, n_t = int(rng.integers(20, 120)), 3 * int(rng.integers(1, 7))
    g = sp.random_array((n_u, n_u), density=0.1, rng=rng)
    A = (g @ g.T + sp.diags_array(rng.uniform(0.5, 2.0, n_u))).tocsr()
    A = ((A + A.T) / 2).tocsr()
    B1 = sp.random_array((n_u, n_t), density=0.2, rng=rng) + sp.csr_array(
        (np.ones(n_t), (np.arange(n_t), np.arange(n_t))), shape=(n_u, n_t)
    )
    k = sp.random_array((n_t, n_t), density=0.3, rng=rng)
    H = (0.1 * (k @ k.T)).tocsr() if rng.random() < 0.6 else None
    H = None if H is None else ((H + H.T) / 2).tocsr()
    B2 = (B1.T * 1.05).tocsr() if rng.random() < 0.3 else None
    n_b = n_u + n_t
    return A, B1.tocsr(), H, B2, rng.standard_normal(n_b)


def whole(A, B1, H, B2):
    """𝒜."""
    n_t = B1.shape[1]
    H = sp.csr_array((n_t, n_t)) if H is None else H
    return sp.block_array([[A, B1], [B1.T if B2 is None else B2, -H]], format="csc")


def laplacian(m: int, faces: int):
    """A 5-point Laplacian on m × m points with tractions on pairs of neighbours, as another code may have it."""
    one = sp.diags_array([-np.ones(m - 1), 2.0 * np.ones(m), -np.ones(m - 1)], offsets=[-1, 0, 1])
    A = sp.kronsum(one, one, format="csr")
    at = (np.arange(faces) * (m * m // faces)) % (m * m - 1)
    B = sp.coo_array(
        (np.r_[np.ones(faces), -np.ones(faces)], (np.r_[at, at + 1], np.r_[np.arange(faces), np.arange(faces)])),
        shape=(m * m, faces),
    ).tocsr()
    return A, B


#: Processes of their own find the same package.
os.environ["PYTHONPATH"] = os.pathsep.join(
    [str(Path(fracas.__file__).parents[1]), *filter(None, [os.environ.get("PYTHONPATH")])]
)


@pytest.fixture(scope="session")
def program() -> Path:
    """`fracas`, built from the same sources."""
    given = os.environ.get("FRACAS_BIN")
    found = Path(given) if given else ROOT / "target" / "release" / "fracas"
    if not found.is_file():
        pytest.skip(f"no program at {found}: build it, or name it in FRACAS_BIN; what Python gives is then not held against it")
    return found


@pytest.fixture
def command(program: Path):
    """Runs the program and returns what it prints."""

    def run(*arguments: object, status: int = 0) -> str:
        done = subprocess.run([program, *map(str, arguments)], capture_output=True, text=True)
        assert done.returncode == status, done.stderr
        return done.stdout

    return run


def bytes_of(folder: Path) -> dict[str, bytes]:
    """Every file below a folder."""
    files = (path for path in sorted(folder.rglob("*")) if path.is_file())
    return {str(path.relative_to(folder)): path.read_bytes() for path in files}


__all__ = ["ROOT", "bytes_of", "laplacian", "random_blocks", "shutil", "whole"]
