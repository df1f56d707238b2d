"""Certificates: sound ones, with something in them changed and, mostly, made to fit again."""

from __future__ import annotations

import copy
import hashlib
import io
import json
import zipfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from fuzz.hostile import (
    FACTORS,
    NUMBERS,
    Rng,
    chance,
    mutate_bytes,
    mutate_tree,
    name,
    pick,
    scale_number,
    slots,
    value,
)

FOREIGN = (b"", b"PK\x03\x04", b"\x93NUMPY\x01\x00", b"not at all", b"{}", b"PK\x05\x06" + bytes(18), b"\x1f\x8b\x08")


@dataclass
class Parts:
    """What is in a certificate file.

    Attributes:
        header: The header's JSON.
        urdf: Text of the URDF.
        records: Arrays by name.
    """

    header: dict[str, Any]
    urdf: str
    records: dict[str, Any]


def parts(data: bytes) -> Parts:
    """Take a sound certificate apart."""
    with np.load(io.BytesIO(data), allow_pickle=False) as content:
        arrays = {key: content[key] for key in content.files}
    header, urdf = (arrays.pop(key).tobytes().decode() for key in ("header", "urdf"))
    return Parts(json.loads(header), urdf, arrays)


def signed(made: Parts) -> None:
    """Make hashes and digest fit again, as far as what is left of the header lets it."""
    records = [made.records[key] for key in sorted(made.records, key=lambda key: (len(key), key))]
    for key in ("sha256", "urdf_sha256"):
        if key in made.header:
            made.header[key] = hashlib.sha256(made.urdf.encode("utf-8", errors="replace")).hexdigest()
    said = {key: item for key, item in made.header.items() if key != "digest"}
    total = hashlib.sha256(json.dumps(said, sort_keys=True, ensure_ascii=False).encode("utf-8", errors="replace"))
    total.update(made.urdf.encode("utf-8", errors="replace"))
    for record in records:
        total.update(np.int64(record.size).tobytes() + record.tobytes())
    made.header["digest"] = total.hexdigest()


def change(rng: Rng, made: Parts, other: Parts) -> None:
    """One change to the content."""
    how = int(rng.integers(12))
    if how <= 3:
        mutate_tree(rng, made.header, other.header)
    elif how == 4:  # a figure, as it is written here
        figures = [(h, k) for h, k in slots(made.header) if isinstance(h[k], str) and "0x" in h[k]]
        if figures:
            holder, key = pick(rng, figures)
            old = float.fromhex(holder[key])
            holder[key] = pick(
                rng,
                [
                    (old * float(pick(rng, FACTORS))).hex(),
                    float(pick(rng, ["nan", "inf", "-inf", "5e-324", "1e300", "0", "1"])).hex(),
                    name(rng),
                ],
            )
    elif how == 5:
        scale_number(rng, made.header)
    elif how == 6:
        key = pick(rng, sorted({**made.header, **other.header}))
        if key in other.header:
            made.header[key] = copy.deepcopy(other.header[key])
    elif how == 7:
        _change_urdf(rng, made, other)
    elif how <= 9 and made.records:
        key = pick(rng, sorted(made.records))
        record = np.array(made.records[key]).ravel()
        replaced = [np.frombuffer(mutate_bytes(rng, record.tobytes()), dtype=np.uint8)]
        if other.records:
            replaced.append(pick(rng, list(other.records.values())))
        replaced += [record.astype(np.float64), record[:, None], np.array([], dtype=np.uint8), np.array(7)]
        made.records[key] = replaced[int(rng.choice(len(replaced)))]
    elif how == 10 and made.records:
        key = pick(rng, sorted(made.records))
        made.records[pick(rng, ["record_7", "record_x", "record_0", "extra", name(rng) or "x"])] = made.records[key]
        if chance(rng, 0.5):
            del made.records[key]
    else:
        made.header[str(pick(rng, ["verdict", "valid", "extra", "format", "level"]))] = value(rng)


def _change_urdf(rng: Rng, made: Parts, other: Parts) -> None:
    how = int(rng.integers(4))
    if how == 0:
        made.urdf = other.urdf
    elif how == 1:
        made.urdf = mutate_bytes(rng, made.urdf.encode(), other.urdf.encode()).decode("utf-8", errors="replace")
    elif how == 2:
        quoted = made.urdf.split('"')
        at = 2 * int(rng.integers(len(quoted) // 2)) + 1
        quoted[at] = str(pick(rng, NUMBERS)) if chance(rng, 0.7) else name(rng)
        made.urdf = '"'.join(quoted)
    else:
        old = str(pick(rng, ["joint_1", "link_1", "j0", "robot", "mass", "value"]))
        made.urdf = made.urdf.replace(old, str(pick(rng, ["Mass", "x", "link_2", "inertia", "<b>"])))


def packed(rng: Rng, made: Parts) -> bytes:
    """The file, now and then in a shape that no `save` has written."""
    buffer = io.BytesIO()
    header = json.dumps(made.header, ensure_ascii=chance(rng, 0.5)).encode("utf-8", errors="surrogatepass")
    arrays = {**made.records}
    arrays["header"] = np.frombuffer(header, dtype=np.uint8)
    arrays["urdf"] = np.frombuffer(made.urdf.encode("utf-8", errors="surrogatepass"), dtype=np.uint8)
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED if chance(rng, 0.8) else zipfile.ZIP_STORED) as archive:
        for key, array in arrays.items():
            inner = io.BytesIO()
            np.lib.format.write_array(inner, np.ascontiguousarray(array), allow_pickle=False)
            data = inner.getvalue()
            if chance(rng, 0.02):  # a shape that is not that of the data
                data = data.replace(b"'shape': (", b"'shape': (9999999", 1)
            if chance(rng, 0.01):  # zeros without end, which deflate to almost nothing
                data += bytes(int(rng.choice([10_000_000, 300_000_000])))
            member = key[:1000].replace("\x00", "").encode("utf-8", "replace").decode()
            archive.writestr(f"{member}.npy", data)
    return buffer.getvalue()


def certificate(rng: Rng, corpus: list[bytes]) -> bytes:
    """One file."""
    data, other = pick(rng, corpus), pick(rng, corpus)
    how = rng.random()
    if how < 0.15:
        return mutate_bytes(rng, data, other)
    if how < 0.18:
        return bytes(pick(rng, FOREIGN)) + (rng.bytes(20) if chance(rng, 0.5) else data[4:])
    if how < 0.2:
        deep = "[" * int(rng.choice([900, 100_000])) if chance(rng, 0.5) else '{"a":' * 50_000
        made = parts(data)
        inner = io.BytesIO()
        np.savez_compressed(inner, header=np.frombuffer(deep.encode(), np.uint8), urdf=np.zeros(0, np.uint8))
        return inner.getvalue()
    made = parts(data)
    for _ in range(int(rng.choice([0, 1, 1, 1, 1, 2, 3, 6]))):
        change(rng, made, parts(other))
    if chance(rng, 0.85):
        signed(made)
    return packed(rng, made)


def make(rng: Rng, folder: Path, corpus: list[bytes]) -> list[str]:
    """Write a certificate into the folder; the command that is to read it.

    Args:
        rng: Where all chance comes from.
        folder: An empty folder, which will be the working directory.
        corpus: Sound certificates.
    """
    (folder / "x.cert").write_bytes(certificate(rng, corpus))
    return ["check", "x.cert", *(["--json"] if chance(rng, 0.85) else [])]
