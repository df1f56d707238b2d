"""Reading NetCDF, Parquet and JSON that a stranger may have made, or a disk damaged.

What a file says of its sizes and types is judged before anything is unpacked: a kilobyte may claim terabytes. Nothing
outside of the file is read, though HDF5 has three ways to ask for it. Whatever the libraries raise on damage becomes
one `ResultError`.
"""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from asmc_pin.disk.reading import check_file, read_file
from asmc_pin.errors import ResultError
from asmc_pin.words.text import printable

if TYPE_CHECKING:
    import h5py  # type: ignore[import-untyped]
    import pandas as pd
    import pyarrow as pa
    import xarray as xr

LARGEST = 2**31
"""Bytes of arrays, as they lie in memory, that are read of a result; a run of one's own may be larger."""

_LARGEST_JSON = 5_000_000
_LARGEST_TABLE = 200_000_000
_MOST_VARIABLES = 200
_MOST_STRINGS = 100_000
_LONGEST_STRING = 1_000
_LONGEST_TEXT = 100_000  # of an attribute or a table's cell: warnings and reasons
_LARGEST_CHUNK = 2**28
_FILTERS = {1: "deflate", 2: "shuffle", 3: "fletcher32"}


def read_arrays(path: Path, largest: float = LARGEST) -> xr.Dataset:
    """A dataset of numbers and short strings.

    Args:
        path: A NetCDF-4 file.
        largest: Bytes in memory at most.

    Raises:
        ResultError: It is damaged, or holds what no result does.
    """
    import h5py
    import xarray as xr

    check_file(path, LARGEST if math.isfinite(largest) else 2**62, "a result's", _fail(path))
    with _one_error(path):
        with h5py.File(path, "r") as file:
            _check_hdf5(path, file, largest)
        # Times stay numbers, and nothing is rescaled: what is stored is what is shown.
        return xr.load_dataset(path, engine="h5netcdf", decode_times=False, mask_and_scale=False)


def read_rows(path: Path, most: int) -> pd.DataFrame:
    """A table of numbers and strings.

    Args:
        path: A Parquet file.
        most: Rows at most.

    Raises:
        ResultError: It is damaged, or holds what no result does.
    """
    import pandas as pd
    import pyarrow.parquet as pq

    data = read_file(path, _LARGEST_TABLE, "a result's", _fail(path))
    with _one_error(path):
        import pyarrow as pa

        file = pq.ParquetFile(pa.BufferReader(data))
        _check_parquet(path, file, most)
        # Strings by their distinct values: a cell that is repeated a million times is kept once.
        strings = [field.name for field in file.schema_arrow if _is_string(field.type)]
        file = pq.ParquetFile(pa.BufferReader(data), read_dictionary=strings)
        table = file.read(use_threads=False)
        for name in strings:
            if any(len(str(text)) > _LONGEST_TEXT for chunk in table[name].chunks for text in chunk.dictionary):
                raise ResultError(path, f"{path}: column '{printable(name)}' has a text of more than 100 kB")
        rows: pd.DataFrame = table.to_pandas(ignore_metadata=True)
        for name in strings:
            rows[name] = pd.Series(rows[name].tolist(), dtype=None if len(rows) else object)
        return rows


def read_json(path: Path) -> dict[str, Any]:
    """A JSON object without NaN.

    Raises:
        ResultError: It is damaged, or something else.
    """
    data = read_file(path, _LARGEST_JSON, "a result's", _fail(path))
    with _one_error(path):
        found = json.loads(data.decode("utf-8"), parse_constant=_no_constant)
    if not isinstance(found, dict):
        raise ResultError(path, f"{path}: holds no JSON object")
    return found


def check_digest(path: Path, provenance: Mapping[str, Any], largest: float = LARGEST) -> None:
    """Whether a file is still the one that the run wrote, as far as its provenance says.

    A flipped bit in a number is no error of any format. And the library that reads HDF5 is not made for damage.

    Raises:
        ResultError: It is another one.
    """
    listed = provenance.get("files", {})
    digest = listed.get(path.name) if isinstance(listed, dict) else None
    if digest is None:
        return
    check_file(path, LARGEST if math.isfinite(largest) else 2**62, "a result's", _fail(path))
    with _one_error(path), path.open("rb") as file:
        found = hashlib.file_digest(file, "sha256").hexdigest()
    if found != digest:
        raise ResultError(path, f"{path}: is damaged or changed: it is not the file whose hash provenance.json has")


@contextmanager
def _one_error(path: Path) -> Iterator[None]:
    """Whatever a library lets through on a damaged file (they do not agree on any class), as one message."""
    try:
        yield
    except ResultError:
        raise
    except Exception as error:
        said = " ".join(str(error).split())
        text = f"{path}: is damaged, or not what its name says ({type(error).__name__}: {printable(said)})"
        raise ResultError(path, text) from error


def _fail(path: Path) -> Any:
    return lambda message: ResultError(path, message)


def _no_constant(name: str) -> None:
    raise ValueError(f"{name} is no JSON")


def _check_hdf5(path: Path, file: h5py.File, largest: float) -> None:
    import h5py

    if len(file) > _MOST_VARIABLES:
        raise ResultError(path, f"{path}: has {len(file)} variables, at most {_MOST_VARIABLES} expected")
    _check_attributes(path, "the file", file)
    total = 0
    for name in file:
        shown = printable(name)
        item = file[name] if isinstance(file.get(name, getlink=True), h5py.HardLink) else None
        if not isinstance(item, h5py.Dataset):
            raise ResultError(
                path, f"{path}: '{shown}' is a group or points elsewhere; a result's file has variables only"
            )
        if item.is_virtual or item.external:
            raise ResultError(path, f"{path}: '{shown}' has its values in another file, which is not read")
        if item.ndim > 4:
            raise ResultError(path, f"{path}: '{shown}' has {item.ndim} dimensions, at most 4 expected")
        plist = item.id.get_create_plist()
        filters = [plist.get_filter(i)[0] for i in range(plist.get_nfilters())]
        if set(filters) - set(_FILTERS):
            raise ResultError(path, f"{path}: '{shown}' is packed by a filter that a result does not use")
        _check_attributes(path, f"'{shown}'", item)
        if h5py.check_string_dtype(item.dtype) is not None:
            _check_strings(path, shown, item)
            continue
        if item.dtype.kind not in "iufb" or item.dtype.itemsize > 8:
            raise ResultError(path, f"{path}: '{shown}' holds neither numbers nor text ({printable(str(item.dtype))})")
        chunk = math.prod(item.chunks) * item.dtype.itemsize if item.chunks else 0
        total += math.prod(item.shape) * item.dtype.itemsize
        if max(chunk - _LARGEST_CHUNK, total - largest) > 0:
            raise ResultError(
                path,
                f"{path}: unpacks to {max(chunk, total) / 1e9:.3g} GB with '{shown}', and no more than "
                f"{min(largest, _LARGEST_CHUNK if chunk > _LARGEST_CHUNK else largest) / 1e9:.3g} GB are read",
            )


def _check_strings(path: Path, shown: str, item: h5py.Dataset) -> None:
    """Numpy gives every string of an array the room of the longest."""
    if math.prod(item.shape) > _MOST_STRINGS or item.ndim > 2:
        raise ResultError(
            path, f"{path}: '{shown}' has {math.prod(item.shape)} texts, at most {_MOST_STRINGS} expected"
        )
    if item.dtype.kind == "S":
        longest = item.dtype.itemsize
    else:
        rows = item.shape[0] if item.ndim else 0
        blocks = (item[start : start + 64] for start in range(0, rows, 64)) if item.ndim else [item[()]]
        longest = max((len(text) for block in blocks for text in _flat(block)), default=0)
    if longest > _LONGEST_STRING:
        raise ResultError(
            path, f"{path}: '{shown}' has a text of {longest} characters, at most {_LONGEST_STRING} expected"
        )


def _flat(block: Any) -> list[bytes]:
    return [block] if isinstance(block, bytes) else list(block.ravel())


def _check_attributes(path: Path, owner: str, item: Any) -> None:
    import h5py

    for name in item.attrs:
        attribute = h5py.h5a.open(item.id, name.encode())
        if math.prod(attribute.shape) > _MOST_STRINGS or attribute.dtype.itemsize > _LONGEST_TEXT:
            raise ResultError(path, f"{path}: attribute '{printable(name)}' of {owner} is too large")
        value = item.attrs[name]
        if isinstance(value, str | bytes) and len(value) > _LONGEST_TEXT:
            raise ResultError(path, f"{path}: attribute '{printable(name)}' of {owner} is too long")


def _check_parquet(path: Path, file: Any, most: int) -> None:
    if file.metadata.num_rows > most:
        raise ResultError(path, f"{path}: has {file.metadata.num_rows} rows, at most {most} expected")
    if file.metadata.num_columns > _MOST_VARIABLES:
        raise ResultError(path, f"{path}: has {file.metadata.num_columns} columns, at most {_MOST_VARIABLES} expected")
    names = file.schema_arrow.names
    if len(set(names)) != len(names):
        raise ResultError(path, f"{path}: two of its columns have the same name")
    size = sum(file.metadata.row_group(i).total_byte_size for i in range(file.metadata.num_row_groups))
    if not 0 <= size <= _LARGEST_TABLE:
        raise ResultError(path, f"{path}: unpacks to {size / 1e9:.3g} GB, at most {_LARGEST_TABLE / 1e9:g} GB are read")
    for field in file.schema_arrow:
        if not (_is_string(field.type) or _is_number(field.type)):
            kind = printable(str(field.type))
            raise ResultError(path, f"{path}: column '{printable(field.name)}' holds neither numbers nor text ({kind})")


def _is_string(kind: pa.DataType) -> bool:
    import pyarrow as pa

    return bool(pa.types.is_string(kind) or pa.types.is_large_string(kind))


def _is_number(kind: pa.DataType) -> bool:
    import pyarrow as pa

    return bool(pa.types.is_integer(kind) or pa.types.is_floating(kind) or pa.types.is_boolean(kind))


Columns = Mapping[str, str]
"""Kind by name: ``"text"``, ``"number"``, ``"count"`` (a whole number of 0 or more) or ``"flag"``."""


def check_columns(path: Path, rows: pd.DataFrame, columns: Columns) -> None:
    """Whether a table has its columns, each of its kind.

    Raises:
        ResultError: One is missing or of another kind.
    """
    absent = [name for name in columns if name not in rows]
    if absent:
        raise ResultError(path, f"{path}: lacks {', '.join(absent)}; made by another version? Run the comparison again")
    for name, kind in columns.items():
        values = rows[name]
        good = {
            "text": all(isinstance(item, str) for item in values),
            "number": values.dtype.kind in "iuf",
            "count": values.dtype.kind in "iu" and bool((values >= 0).all()),
            "flag": values.dtype.kind == "b",
        }[kind]
        if not good:
            raise ResultError(path, f"{path}: column '{name}' holds something else than a {kind} in each row")
