"""The file of a certificate: an npz archive with three kinds of members, read within bounds and believed in nothing.

Content: ``header`` (JSON text), ``urdf`` (the URDF's text), ``record_K`` (the bisection of statement K, uint8). The
header holds the statements, the boxes, what was done to the arm (locked joints, payload, armature), some of its inertia
matrices, all as exact numbers (hexadecimal floats), and a digest of all else.

This is all that the prover and the checker share of each other.
"""

from __future__ import annotations

import hashlib
import io
import json
import re
import stat
import zipfile
import zlib
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.disk.reading import user_path
from asmc_pin.errors import ResultError

FORMAT = "asmc-pin certificate 1"

MOST_HEADER, MOST_URDF, MOST_RECORDS = 16_000_000, 4_000_000, 32_000_000
"""Bytes that are unpacked of the header, of the URDF and of all records together; far above what a proof needs."""

MOST_STATEMENTS = 10_000

_MOST_FILE = 64_000_000
_NPY_HEAD = 4096
_NPY = re.compile(
    rb"\x93NUMPY\x01\x00..\{'descr': '\|u1', 'fortran_order': False, 'shape': \(([0-9]{1,9}),\), \} *\n", re.DOTALL
)
"""How numpy begins a row of bytes in version 1.0 of its format, and nothing else that its reader would take."""

_MEMBER = re.compile(r"header|urdf|record_(0|[1-9][0-9]{0,4})")

Record = np.ndarray[Any, np.dtype[np.uint8]]


@dataclass(frozen=True, eq=False)
class Container:
    """What stands in the file.

    Attributes:
        header: A JSON object that says that it is of this format; nothing else of it is known.
        urdf: Text.
        records: One array of bytes per statement.
    """

    header: dict[str, Any]
    urdf: str
    records: list[Record]


class _Damaged(ValueError):
    """It is not an archive of this kind; the message says why."""


def read(path: str | Path) -> Container:
    """Header, URDF text and records of a certificate file, as they stand.

    Raises:
        ResultError: No such file, not a certificate, of another format, or larger than any certificate.
    """
    source = user_path(path)
    try:
        members = _members(_bytes_of(source))
        header = json.loads(members["header"].tobytes().decode())
        urdf = members["urdf"].tobytes().decode()
    except OSError as error:
        raise ResultError(source, f"cannot read the certificate {source}: {error.strerror or error}") from None
    except _Damaged as error:
        raise ResultError(source, f"{source} is not a certificate ({error}); {_REMEDY}") from None
    except (UnicodeDecodeError, json.JSONDecodeError, RecursionError):
        raise ResultError(source, f"{source} is not a certificate (its header is no JSON text); {_REMEDY}") from None
    except ValueError:  # Python's limit of the digits of a whole number
        raise ResultError(source, f"{source} is not a certificate (a number without end in it); {_REMEDY}") from None
    if not isinstance(header, dict) or not isinstance(header.get("format"), str):
        raise ResultError(source, f"{source} is not a certificate (its header says no format); {_REMEDY}")
    if header["format"] != FORMAT:
        raise ResultError(source, f"{source} is not of the format '{FORMAT}', which is what this version checks")
    count = len(members) - 2
    absent = [k for k in range(count) if f"record_{k}" not in members]
    if absent:
        raise ResultError(source, f"{source} is not a certificate (record {absent[0]} is missing); {_REMEDY}")
    return Container(header, urdf, [members[f"record_{k}"] for k in range(count)])


_REMEDY = "write one with: asmc-pin verify … --certify --certificate FILE"


def _bytes_of(source: Path) -> bytes:
    # A device never ends, a pipe waits for who never writes, and a directory has no bytes.
    kind = source.stat().st_mode
    if not stat.S_ISREG(kind):
        raise _Damaged("it is a folder" if stat.S_ISDIR(kind) else "it is no regular file")
    with source.open("rb") as file:
        data = file.read(_MOST_FILE + 1)
    if len(data) > _MOST_FILE:
        raise _Damaged(f"it is larger than {_MOST_FILE // 1_000_000} MB")
    # Every entry of an archive's list has this mark; a list of a million would be read whole before it is counted.
    if data.count(b"PK\x01\x02") > 2 * MOST_STATEMENTS:
        raise _Damaged("it has too many parts")
    return data


def _members(data: bytes) -> dict[str, Record]:
    """The members by name, none of them larger unpacked than it may be."""
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            infos = archive.infolist()
            if len(infos) > MOST_STATEMENTS + 2:
                raise _Damaged("it has too many parts")
            found: dict[str, Record] = {}
            left = MOST_RECORDS
            for info in infos:
                name = info.filename.removesuffix(".npy")
                if not _MEMBER.fullmatch(name) or name in found:
                    raise _Damaged("it has parts that a certificate has not")
                if info.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED) or info.flag_bits & 1:
                    raise _Damaged("it is packed as no certificate is")
                most = {"header": MOST_HEADER, "urdf": MOST_URDF}.get(name, left)
                with archive.open(info) as member:
                    found[name] = _array(member, most)
                if name.startswith("record_"):
                    left -= found[name].size
    except (zipfile.BadZipFile, zlib.error, NotImplementedError, RuntimeError, EOFError, OverflowError) as error:
        raise _Damaged(f"damaged: {error}" if str(error) else "damaged") from None
    if "header" not in found or "urdf" not in found:
        raise _Damaged("it has no header or no URDF")
    return found


def _array(member: IO[bytes], most: int) -> Record:
    """A row of bytes in numpy's format, read without trusting the size that it gives itself."""
    data = member.read(most + _NPY_HEAD + 1)
    if len(data) > most + _NPY_HEAD:
        raise _Damaged("a part of it unpacks to more than a certificate has")
    head = _NPY.match(data)
    if head is None:
        raise _Damaged("a part of it is no row of bytes")
    body = data[10 + int.from_bytes(data[8:10], "little") :]
    if head.end() != len(data) - len(body) or int(head[1]) != len(body):
        raise _Damaged("a part of it is no row of bytes")
    return np.frombuffer(body, dtype=np.uint8)


def digest(header: dict[str, Any], urdf: str, records: list[Record]) -> str:
    """SHA-256 of all that a certificate says, but for the digest itself."""
    said = {key: value for key, value in header.items() if key != "digest"}
    # What is no text in UTF-8, such as half a surrogate pair, is hashed as the escape that it was written as.
    total = hashlib.sha256(json.dumps(said, sort_keys=True, ensure_ascii=False).encode(errors="backslashreplace"))
    total.update(urdf.encode())
    for record in records:
        total.update(np.int64(record.size).tobytes() + record.tobytes())
    return total.hexdigest()


def numbers(values: Array) -> Any:
    """Nested lists of hexadecimal floats, exact."""
    if values.ndim == 0:
        return float(values).hex()
    return [numbers(row) for row in values]
