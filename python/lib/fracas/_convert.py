"""What users give, as the arrays that the extension module takes; whatever does not fit is named."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._errors import Error, InputError, SystemInputError, WrongType

Vector = NDArray[np.float64]
Rows = tuple[int, int, NDArray[np.int64], NDArray[np.int32], Vector]


def kind(value: object) -> str:
    """What messages call the kind of a value."""
    if isinstance(value, np.ndarray):
        return f"an array of {value.dtype} with shape {value.shape}"
    return f"a {type(value).__module__}.{type(value).__qualname__}".replace("builtins.", "")


def numbers(name: str, value: Any) -> NDArray[Any]:
    """An array of real numbers in f64; integers are converted, everything else is refused."""
    try:
        array = np.asarray(value)
    except Exception as error:
        raise WrongType(f"{name}: expected numbers, not {kind(value)}: {error}") from error
    if array.dtype.kind not in "iuf":
        given = f"an array of {array.dtype}" if isinstance(value, np.ndarray) else kind(value)
        raise WrongType(f"{name}: expected real numbers (float64), not {given}")
    return np.require(array, np.float64, ["C", "A"])


def vector(name: str, value: Any, n: int | None = None) -> Vector:
    """A vector of n entries; a column counts as one."""
    array = numbers(name, value)
    if array.ndim == 2 and 1 in array.shape:
        array = array.reshape(-1)
    if array.ndim != 1 or (n is not None and array.size != n):
        expected = "a vector" if n is None else f"a vector of {n} entries"
        raise InputError(f"{name}: expected {expected}, not shape {np.shape(value)}")
    return array


def sparse() -> Any:
    """scipy.sparse, without which only what needs no matrix of Python's works."""
    try:
        import scipy.sparse
    except ImportError as error:
        raise Error("this needs scipy, which is not installed: pip install scipy") from error
    return scipy.sparse


def _rows_of_dense(name: str, value: Any) -> Rows:
    table = numbers(name, value)
    if table.ndim != 2:
        raise SystemInputError(f"{name}: expected a matrix, not shape {table.shape}")
    at = np.nonzero(table)
    starts = np.zeros(table.shape[0] + 1, np.int64)
    np.cumsum(np.count_nonzero(table, axis=1), out=starts[1:])
    return table.shape[0], table.shape[1], starts, at[1].astype(np.int32), table[at]


def rows(name: str, value: Any) -> Rows:
    """Compressed rows of a scipy.sparse matrix, of a dense array, or of anything with `tocsr`."""
    if hasattr(value, "tocsr"):
        csr = value.tocsr()
    elif isinstance(value, (np.ndarray, list, tuple)):
        return _rows_of_dense(name, value)
    else:
        raise WrongType(f"{name}: expected a scipy.sparse matrix or a 2-D array, not {kind(value)}")
    if csr.data.dtype.kind not in "iuf":
        raise WrongType(f"{name}: expected real entries (float64), not {csr.data.dtype}")
    # scipy goes where indptr points
    starts = csr.indptr
    if len(starts) != csr.shape[0] + 1 or starts[0] != 0 or starts[-1] > len(csr.indices) or (np.diff(starts) < 0).any():
        raise SystemInputError(f"{name}: indptr does not count the entries of its rows: it grows from 0 to the number of entries")
    if not csr.has_canonical_format:
        csr = csr.copy()
        csr.sum_duplicates()
    n, m = csr.shape
    if max(n, m, 1) > np.iinfo(np.int32).max:
        raise SystemInputError(f"{name}: {n} x {m} is more than 32-bit indices count")
    return (
        int(n),
        int(m),
        np.ascontiguousarray(csr.indptr, dtype=np.int64),
        np.ascontiguousarray(csr.indices, dtype=np.int32),
        np.ascontiguousarray(csr.data, dtype=np.float64),
    )


def matrix(found: Any) -> Any:
    """A scipy.sparse.csr_array over memory of the extension module: entries and columns are shared and read-only."""
    if found is None:
        return None
    csr_array = sparse().csr_array
    n, m, starts, columns, values = found
    if columns.dtype != np.int32:
        columns = columns.view(np.int32)
    if starts[-1] <= np.iinfo(np.int32).max:
        starts = starts.astype(np.int32)
    shared = csr_array((values, columns, starts), shape=(n, m), copy=False)
    shared.has_canonical_format = True
    return shared


def share(given: Any, found: Any) -> None:
    """Lets a matrix of the user's in compressed rows show memory of the extension module in place of its own, read-only."""
    if found is None or getattr(given, "format", None) != "csr" or given.dtype != np.float64:
        return
    shared = matrix(found)
    if given.shape == shared.shape and given.nnz == shared.nnz:
        given.data, given.indices, given.indptr = shared.data, shared.indices, shared.indptr


def coordinates(value: Any, n_u: int) -> Any:
    """`n_u` rows `x y z component`, or `n_u / 3` rows `x y z`."""
    if value is None:
        return None
    table = numbers("coordinates", value)
    if table.shape == (n_u, 4):
        found = table
    elif table.ndim == 2 and table.shape[1] == 3 and 3 * table.shape[0] == n_u:
        components = np.tile(np.arange(3.0), table.shape[0])
        found = np.column_stack([np.repeat(table, 3, axis=0), components])
    else:
        raise SystemInputError(
            f"coordinates: expected {n_u} rows x y z component, or {n_u // 3} rows x y z, not shape {table.shape}"
        )
    if not np.isfinite(found).all():
        row = int(np.argwhere(~np.isfinite(found))[0][0])
        raise SystemInputError(f"coordinates: row {row} (counted from 0) holds {found[row]}")
    return np.ascontiguousarray(found)


def _plain(value: Any) -> Any:
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, np.ndarray):
        return value.tolist()
    raise WrongType(f"settings hold {kind(value)}: expected numbers, strings, lists and dictionaries")


def text(settings: dict[str, Any]) -> str:
    """Settings as JSON."""
    return json.dumps(settings, default=_plain, allow_nan=False)


def toml(table: dict[str, Any], what: str) -> str:
    """A dictionary as TOML."""
    lines: list[str] = []
    _tables(table, [], lines, what)
    return "\n".join(lines) + "\n"


def _key(key: object, what: str) -> str:
    if not isinstance(key, str):
        raise WrongType(f"{what}: keys are strings, not {kind(key)}")
    bare = key.replace("-", "").replace("_", "").isalnum() and key.isascii()
    return key if bare else _quoted(key)


def _quoted(text: str) -> str:
    """A string of TOML: one of JSON, but for DEL, which TOML does not take as it is."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def _value(value: Any, where: str, what: str) -> str:
    if isinstance(value, (np.generic, np.ndarray)):
        value = value.tolist()
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int):
        return str(value)
    if isinstance(value, float):
        return repr(value) if np.isfinite(value) else str(value)
    if isinstance(value, str):
        return _quoted(value)
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(_value(v, where, what) for v in value) + "]"
    if isinstance(value, dict):
        items = (f"{_key(k, what)} = {_value(v, where, what)}" for k, v in value.items())
        return "{ " + ", ".join(items) + " }"
    raise WrongType(f"{what}: {where} is {kind(value)}: expected a number, a string, a list or a dictionary")


def _tables(table: dict[str, Any], path: list[str], lines: list[str], what: str) -> None:
    def is_tables(value: Any) -> bool:
        return isinstance(value, (list, tuple)) and len(value) > 0 and all(isinstance(v, dict) for v in value)

    for key, value in table.items():
        if not isinstance(value, dict) and not is_tables(value):
            where = ".".join([*path, str(key)])
            lines.append(f"{_key(key, what)} = {_value(value, where, what)}")
    for key, value in table.items():
        inner = [*path, _key(key, what)]
        if isinstance(value, dict):
            lines.append(f"[{'.'.join(inner)}]")
            _tables(value, inner, lines, what)
        elif is_tables(value):
            for entry in value:
                lines.append(f"[[{'.'.join(inner)}]]")
                _tables(entry, inner, lines, what)
