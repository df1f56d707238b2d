"""A table of numbers as people save one: CSV with ``,``, ``;`` or tabs, also gzipped, or Parquet.

What a file is, its first bytes say, not its name.
"""

from __future__ import annotations

import gzip
import io
import re
import zlib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.disk.reading import Fail, read_file, shown
from asmc_pin.errors import AsmcPinError
from asmc_pin.words.text import printable

LARGEST = 1_000_000_000
"""Bytes of a recording at most, unpacked: an hour of seven joints at 1 kHz."""

MOST_COLUMNS = 10_000

_GZIP, _PARQUET = b"\x1f\x8b", b"PAR1"


def read_table(path: Path, fail: Fail) -> Any:
    """Read a table.

    Args:
        path: The file.
        fail: Makes the error of the caller's kind.

    Returns:
        A pandas table with stripped names of columns, every cell as it was read.

    Raises:
        AsmcPinError: What `fail` makes: it is no such file, too large, or damaged.
    """

    def wrong(message: str) -> AsmcPinError:
        return fail(
            f"{shown(path)} cannot be read: {message.removeprefix(f'{shown(path)}: ').removeprefix('cannot be read ')}"
        )

    data = read_file(path, LARGEST, "a recording", wrong)
    if data[:2] == _GZIP:
        data = _unpacked(data, wrong)
    table = _parquet(data, wrong) if data[:4] == _PARQUET else _csv(data, wrong)
    table.columns = [str(name).strip() for name in table.columns]
    return table


def numbers(path: Path, table: Any, columns: Sequence[str], fail: Fail, *, gaps: bool = False) -> Array:
    """Columns of a table as numbers.

    Args:
        path: Where it came from.
        table: From `read_table`.
        columns: Which.
        fail: Makes the error.
        gaps: Whether an empty cell or a NaN is one, instead of an error.

    Returns:
        Shape (rows, columns).

    Raises:
        AsmcPinError: What `fail` makes; names the line and the column.
    """
    import pandas as pd

    def column(name: str) -> Array:
        try:
            return np.asarray(pd.to_numeric(table[name], errors="coerce"), dtype=np.float64)
        except OverflowError:  # an integer beyond any float; as text it is infinite
            return np.asarray(pd.to_numeric(table[name].astype(str), errors="coerce"), dtype=np.float64)

    values = np.column_stack([column(name) for name in columns])
    bad = ~np.isfinite(values)
    if gaps:
        empty = np.column_stack(
            [pd.isna(table[name]) | (table[name].astype(str).str.strip() == "") for name in columns]
        )
        bad &= ~empty
    places = np.argwhere(bad)
    if places.size:
        row, place = places[0]
        given = printable(repr(table[columns[place]].iloc[row]))
        raise fail(f"{path.name}, line {row + 2}, column '{printable(columns[place])}': {given} is not a finite number")
    return values


def _unpacked(data: bytes, wrong: Fail) -> bytes:
    try:
        with gzip.GzipFile(fileobj=io.BytesIO(data)) as file:
            found = file.read(LARGEST + 1)
    except (OSError, EOFError, zlib.error) as error:
        raise wrong(f"its gzip is damaged ({error})") from None
    if len(found) > LARGEST:
        raise wrong(f"unpacked it has more than {LARGEST / 1e6:.4g} MB")
    return found


def _parquet(data: bytes, wrong: Fail) -> Any:
    import pandas as pd

    try:
        return pd.read_parquet(io.BytesIO(data))
    except Exception as error:  # pyarrow's errors have nothing in common
        raise wrong(f"its Parquet is damaged ({printable(' '.join(str(error).split()))})") from None


def _csv(data: bytes, wrong: Fail) -> Any:
    import pandas as pd

    end = data.find(b"\n")
    header = data[: end if end >= 0 else None]
    mark = max((b",", b";", b"\t"), key=header.count)
    # Before pandas sees it, which takes a kilobyte for every column, whatever it holds.
    if header.count(mark) >= MOST_COLUMNS:
        raise wrong(f"its header has more than {MOST_COLUMNS} columns")
    second = data[end + 1 : data.find(b"\n", end + 1)] if end >= 0 else b""
    # A semicolon is what those write between columns whose numbers have a comma.
    decimal = "," if mark == b";" and re.search(rb"\d,\d", second) else "."
    try:
        table = pd.read_csv(
            io.BytesIO(data), sep=mark.decode(), decimal=decimal, skipinitialspace=True, encoding="utf-8-sig"
        )
    except Exception as error:  # pandas' parsers raise classes that have nothing in common
        raise wrong(printable(" ".join(str(error).split())) or type(error).__name__) from None
    if not isinstance(table.index, pd.RangeIndex):
        raise wrong("its rows have more values than its header has names")
    return table
