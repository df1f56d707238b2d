"""What a stranger may put into a certificate: read as what it is, or refused in bounded time and memory."""

from __future__ import annotations

import copy
import io
import json
import os
import struct
import threading
import tracemalloc
import zipfile
import zlib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from arm_urdf import LIMIT, inertial, joint, link, robot
from check_cases import case, header, hexed, statement

from asmc_pin import load_arm
from asmc_pin.arms import arm_names
from asmc_pin.condition.certificate.container import FORMAT, digest, read
from asmc_pin.condition.checker import check
from asmc_pin.condition.checker.reading.certificate_schema import contents
from asmc_pin.condition.checker.reading.header_parts import Malformed
from asmc_pin.condition.checker.reading.link_chain import chain_of
from asmc_pin.condition.checker.reading.urdf_text import Unreadable, description
from asmc_pin.errors import ResultError

MEGABYTE = 1_000_000

# The container ------------------------------------------------------------------------------------------------------


def _npy(data: bytes, head: str | None = None) -> bytes:
    said = f"{{'descr': '|u1', 'fortran_order': False, 'shape': ({len(data)},), }}" if head is None else head
    text = said.encode() + b" " * (-(11 + len(said)) % 64) + b"\n"
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(text)) + text + data


def _archive(members: dict[str, bytes], method: int = zipfile.ZIP_DEFLATED) -> bytes:
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", method) as archive:
        for name, data in members.items():
            archive.writestr(f"{name}.npy", data)
    return buffer.getvalue()


def _members(said: bytes | None = None, urdf: bytes = b"<robot/>", records: int = 1) -> dict[str, bytes]:
    text = json.dumps({"format": FORMAT}).encode() if said is None else said
    parts = {"header": _npy(text), "urdf": _npy(urdf)}
    return parts | {f"record_{k}": _npy(b"\xff") for k in range(records)}


def _refused(folder: Path, data: bytes, why: str = "not a certificate") -> None:
    path = folder / "it.cert"
    path.write_bytes(data)
    with pytest.raises(ResultError, match=why) as error:
        read(path)
    assert "\n" not in str(error.value)


def test_a_container_is_read_as_it_was_written(tmp_path: Path) -> None:
    for method in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
        (tmp_path / "good.cert").write_bytes(_archive(_members(urdf="<robot name='é'/>".encode(), records=12), method))
        found = read(tmp_path / "good.cert")
        assert found.header == {"format": FORMAT}
        assert found.urdf == "<robot name='é'/>"
        assert [record.tolist() for record in found.records] == [[255]] * 12
    (tmp_path / "empty.cert").write_bytes(_archive(_members(urdf=b"") | {"record_0": _npy(b"")}))
    assert read(tmp_path / "empty.cert").records[0].size == 0


def test_a_swollen_file_is_refused_in_bounded_memory(tmp_path: Path) -> None:
    zeros = zlib.compressobj(9, zlib.DEFLATED, -15)
    packed = b"".join(zeros.compress(bytes(MEGABYTE)) for _ in range(300)) + zeros.flush()
    for name in ("header", "urdf", "record_0"):
        data = bytearray(_archive(_members() | {name: b"x" * 20}))
        # The stream of the member is replaced by one of 300 MB, and its sizes are told as they were.
        info = zipfile.ZipFile(io.BytesIO(bytes(data))).getinfo(f"{name}.npy")
        start = info.header_offset + 30 + len(info.filename)
        grown = data[:start] + packed + data[start + info.compress_size :]
        where = grown.index(b"PK\x01\x02")
        directory = grown[where:]
        shift = len(packed) - info.compress_size
        at = 0
        while directory[at : at + 4] == b"PK\x01\x02":
            length = struct.unpack_from("<H", directory, at + 28)[0]
            if bytes(directory[at + 46 : at + 46 + length]) == f"{name}.npy".encode():
                struct.pack_into("<LL", directory, at + 20, len(packed), 300 * MEGABYTE)
            elif struct.unpack_from("<L", directory, at + 42)[0] > info.header_offset:
                struct.pack_into("<L", directory, at + 42, struct.unpack_from("<L", directory, at + 42)[0] + shift)
            at += 46 + length
        struct.pack_into("<L", directory, at + 16, where)
        path = tmp_path / "bomb.cert"
        path.write_bytes(bytes(grown[:where]) + bytes(directory))
        assert path.stat().st_size < MEGABYTE
        tracemalloc.start()
        with pytest.raises(ResultError, match=r"unpacks to more|damaged"):
            read(path)
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        assert peak < 100 * MEGABYTE


def test_records_share_one_allowance(tmp_path: Path) -> None:
    part = _npy(bytes(17 * MEGABYTE))
    _refused(tmp_path, _archive(_members() | {"record_0": part, "record_1": part}), "unpacks to more")
    (tmp_path / "one.cert").write_bytes(_archive(_members() | {"record_0": part}))
    assert read(tmp_path / "one.cert").records[0].size == 17 * MEGABYTE


def test_a_list_of_a_million_parts_is_not_read(tmp_path: Path) -> None:
    entry = struct.pack("<4sHHHHHHLLLHHHHHLL", b"PK\1\2", 20, 20, 0, 0, 0, 33, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0) + b"a"
    listed = entry * 1_000_000
    end = struct.pack("<4sHHHHLLH", b"PK\5\6", 0, 0, 0xFFFF, 0xFFFF, len(listed), 0, 0)
    tracemalloc.start()
    _refused(tmp_path, listed + end, "too many parts")
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 3 * len(listed)


HEADS = {
    "pickled": "{'descr': '|O', 'fortran_order': False, 'shape': (1,), }",
    "another type": "{'descr': '<f8', 'fortran_order': False, 'shape': (1,), }",
    "signed bytes": "{'descr': '|i1', 'fortran_order': False, 'shape': (8,), }",
    "columns first": "{'descr': '|u1', 'fortran_order': True, 'shape': (8,), }",
    "a table": "{'descr': '|u1', 'fortran_order': False, 'shape': (2, 4), }",
    "a number": "{'descr': '|u1', 'fortran_order': False, 'shape': (), }",
    "larger than it is": "{'descr': '|u1', 'fortran_order': False, 'shape': (9,), }",
    "smaller than it is": "{'descr': '|u1', 'fortran_order': False, 'shape': (7,), }",
    "larger than the world": "{'descr': '|u1', 'fortran_order': False, 'shape': (99999999999999999999,), }",
    "negative": "{'descr': '|u1', 'fortran_order': False, 'shape': (-8,), }",
    "of a former Python": "{'descr': '|u1', 'fortran_order': False, 'shape': (8L,), }",
    "an expression": "__import__('os').system('true')",
    "open brackets": "{'a': (",
    "an open text": "'''",
    "brackets without end": "(" * 3000,
    "two dictionaries": "{'descr': '|u1', 'fortran_order': False, 'shape': (8,), }" * 2,
    "nothing": "",
    "nul": "\0" * 40,
}


@pytest.mark.parametrize("what", HEADS)
@pytest.mark.filterwarnings("error")
def test_a_part_that_is_no_row_of_bytes_is_refused_without_being_evaluated(what: str, tmp_path: Path) -> None:
    for name in ("header", "urdf", "record_0"):
        _refused(tmp_path, _archive(_members() | {name: _npy(b"12345678", HEADS[what])}), "no row of bytes")


@pytest.mark.parametrize(
    "start", [b"", b"\x93NUMPY", b"\x93NUMPY\x02\x00", b"\x93NUMPX\x01\x00", b"\x93NUMPY\x01\x00\xff\xff", b"\0" * 200]
)
def test_a_part_that_does_not_begin_as_one_is_refused(start: bytes, tmp_path: Path) -> None:
    _refused(tmp_path, _archive(_members() | {"urdf": start}), "no row of bytes")
    whole = _npy(b"12345678")
    _refused(tmp_path, _archive(_members() | {"urdf": start + whole[len(start) :]} if len(start) == 8 else
                                _members() | {"urdf": whole + b"9"}), "no row of bytes")  # fmt: skip


@pytest.mark.parametrize(
    "names",
    [
        ("header", "urdf", "record_0", "record_0"),
        ("header", "urdf", "other"),
        ("header", "urdf", "record_00"),
        ("header", "urdf", "record_-1"),
        ("header", "urdf", "record_١"),
        ("header", "urdf", "record_123456"),
        ("header", "urdf", "../header"),
        ("header", "urdf", "header\0x"),
        ("header", "urdf", "record_0\n"),
        ("header", "header", "urdf"),
        ("header", "record_0"),
        ("urdf", "record_0"),
        ("header", "urdf", "record_1"),
        (),
    ],
)
@pytest.mark.filterwarnings("ignore:Duplicate name")
def test_other_parts_than_a_certificate_has_are_refused(names: tuple[str, ...], tmp_path: Path) -> None:
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        for name in names:
            archive.writestr(f"{name.replace(chr(0), '0')}.npy", _members().get(name, _npy(b"\xff")))
    data = buffer.getvalue()
    if any("\0" in name for name in names):
        data = data.replace(b"header0x", b"header\0x")
    _refused(tmp_path, data)


@pytest.mark.parametrize("method", [zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA])
def test_other_packings_are_refused(method: int, tmp_path: Path) -> None:
    _refused(tmp_path, _archive(_members(), method), "packed")


def test_an_encrypted_part_and_parts_that_overlap_are_refused(tmp_path: Path) -> None:
    good = _archive(_members())
    locked = bytearray(good)
    at = locked.index(b"PK\x01\x02")
    locked[at + 8] |= 1
    _refused(tmp_path, bytes(locked), "packed")
    # Every entry of the list points to the first part.
    shared = bytearray(good)
    while at >= 0:
        struct.pack_into("<L", shared, at + 42, 0)
        at = shared.find(b"PK\x01\x02", at + 1)
    _refused(tmp_path, bytes(shared))


def test_a_file_that_is_cut_or_flipped_anywhere_is_refused_or_read(tmp_path: Path) -> None:
    good = _archive(_members(records=2), zipfile.ZIP_STORED)
    path = tmp_path / "it.cert"
    for end in range(0, len(good), 97):
        path.write_bytes(good[:end])
        with pytest.raises(ResultError, match="not a certificate"):
            read(path)
    flipped = 0
    for at in range(0, len(good), 7):
        path.write_bytes(good[:at] + bytes([good[at] ^ 0x41]) + good[at + 1 :])
        try:
            read(path)
        except ResultError:
            flipped += 1
    assert flipped > 40
    for tail in (b"\0" * 100, b"PK\x05\x06"):
        path.write_bytes(good + tail)
        try:
            read(path)
        except ResultError:
            continue


def test_what_is_no_regular_file_is_refused_at_once(tmp_path: Path) -> None:
    fifo = tmp_path / "fifo"
    os.mkfifo(fifo)
    said: list[str] = []

    def ask() -> None:
        for path in (fifo, Path("/dev/zero"), tmp_path, tmp_path / "nothing"):
            try:
                read(path)
            except ResultError as error:
                said.append(str(error))

    asking = threading.Thread(target=ask, daemon=True)
    asking.start()
    asking.join(timeout=120.0)
    assert len(said) == 4, said
    assert "no regular file" in said[0]
    assert "no regular file" in said[1]
    assert "is a folder" in said[2]
    assert "cannot read" in said[3]
    good = tmp_path / "good.cert"
    good.write_bytes(_archive(_members()))
    (tmp_path / "link.cert").symlink_to(good)
    assert read(tmp_path / "link.cert").header == {"format": FORMAT}
    (tmp_path / "loop.cert").symlink_to(tmp_path / "loop.cert")
    with pytest.raises(ResultError, match="cannot read"):
        read(tmp_path / "loop.cert")


def test_a_file_larger_than_any_certificate_is_not_read_whole(tmp_path: Path) -> None:
    large = tmp_path / "large.cert"
    with large.open("wb") as file:
        file.truncate(1 << 40)
    tracemalloc.start()
    with pytest.raises(ResultError, match="larger than"):
        read(large)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 200 * MEGABYTE


# The header's text --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "said",
    [
        b"",
        b"\xff\xfe",
        b"nul\0",
        b"[]",
        b'"text"',
        b"1",
        b"null",
        b"{}",
        b'{"format": 1}',
        b'{"format": "asmc-pin certificate 1"',
        b'{"format": "asmc-pin certificate 1", "a": ' + b"1" * 1_000_000 + b"}",
        b"[" * 1_000_000,
    ],
    ids=lambda said: f"{said[:12]!r}{len(said)}",
)
def test_a_header_that_is_no_object_of_this_format_is_refused(said: bytes, tmp_path: Path) -> None:
    _refused(tmp_path, _archive(_members(said)), "is not")


@pytest.mark.parametrize("depth", [16, 100, 400, 600, 900, 990, 2000, 100_000])
def test_a_header_of_any_depth_is_refused_or_not_valid(depth: int, tmp_path: Path) -> None:
    for first, last in ((b"[", b"]"), (b'{"a":', b"}")):
        said = b'{"format": "asmc-pin certificate 1", "a": ' + first * depth + b"1" + last * depth + b"}"
        path = tmp_path / "deep.cert"
        path.write_bytes(_archive(_members(said)))
        try:
            valid = check(path).valid
        except ResultError:
            valid = False
        assert not valid


@pytest.mark.parametrize(
    "text", ['"\\ud800"', '"\\ud800\\udc00"', '"\\u0000"', '"é\\u202e"', "1e999", "NaN", "-Infinity"]
)
def test_any_text_and_number_of_a_header_has_a_digest(text: str, tmp_path: Path) -> None:
    path = tmp_path / "it.cert"
    key = text if text.startswith('"') else '"b"'
    path.write_bytes(_archive(_members(f'{{"format": "{FORMAT}", {key}: 1, "a": {text}}}'.encode())))
    found = read(path)
    first = digest(found.header, found.urdf, found.records)
    assert len(first) == 64
    other = copy.deepcopy(found.header)
    other["a"] = "another"
    assert digest(other, found.urdf, found.records) != first
    # And the check of it says no, in text that any terminal takes.
    said = check(path)
    assert not said.valid
    "\n".join(said.lines()).encode()
    json.dumps(said.to_json_dict(), ensure_ascii=False).encode()


def test_a_digest_is_of_everything_but_itself() -> None:
    records = [np.array([0, 255, 255], dtype=np.uint8), np.array([255], dtype=np.uint8)]
    base = digest({"a": 1, "b": [1, 2]}, "text", records)
    assert digest({"b": [1, 2], "a": 1, "digest": "any"}, "text", records) == base
    changed = [
        digest({"a": 1, "b": [2, 1]}, "text", records),
        digest({"a": 1, "b": [1, 2], "c": 0}, "text", records),
        digest({"a": 1, "b": [1, 2]}, "text ", records),
        digest({"a": 1, "b": [1, 2]}, "text", records[::-1]),
        digest({"a": 1, "b": [1, 2]}, "text", records[:1]),
        # The same bytes, divided elsewhere.
        digest({"a": 1, "b": [1, 2]}, "text", [np.array([0, 255, 255, 255], dtype=np.uint8)]),
        digest({"a": "\\ud800", "b": [1, 2]}, "text", records),
    ]
    assert len({base, *changed}) == 8


# The header's fields ------------------------------------------------------------------------------------------------

LOAD = {"mass": "0x1p+0", "com": hexed([0.1, 0.0, 0.0]), "inertia": hexed([0.01, 0, 0, 0.01, 0, 0.01]), "link": "l1"}


def _whole() -> dict[str, Any]:
    whole = header(
        2,
        condition="lemma1",
        cases=[case(2, payload=LOAD, locked={"k": 0.5}), case(2)],
        statements=[statement(2, "level"), statement(2, "lemma1", case=1)],
        level=0.5,
        upper=0.75,
    )
    return copy.deepcopy(whole)


def _fields(value: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[tuple[Any, ...], Any]]:
    """Every place of a header, and what stands there."""
    if path:
        yield path, value
    if isinstance(value, dict):
        for key, item in value.items():
            yield from _fields(item, (*path, key))
    elif isinstance(value, list):
        for k, item in enumerate(value):
            yield from _fields(item, (*path, k))


def _at(whole: Any, path: tuple[Any, ...]) -> Any:
    for key in path:
        whole = whole[key]
    return whole


FIELDS = dict(_fields(_whole()))
NUMBERS = [path for path, value in FIELDS.items() if isinstance(value, (int, float))]
HEXES = [path for path, value in FIELDS.items() if isinstance(value, str) and value.startswith(("0x", "-0x"))]
OBJECTS = [(), *(path for path, value in FIELDS.items() if isinstance(value, dict))]


def _changed(path: tuple[Any, ...], value: Any) -> dict[str, Any]:
    whole = _whole()
    _at(whole, path[:-1])[path[-1]] = value
    return whole


def test_the_header_of_these_tests_is_taken_as_it_is() -> None:
    found = contents(_whole())
    assert found.cases[0].payload is not None
    assert found.cases[0].payload.mass == 1.0
    assert found.cases[0].locked == {"k": 0.5}
    assert (len(NUMBERS), len(HEXES) > 40, len(OBJECTS)) == (13, True, 10)


WRONG: list[Any] = [True, None, "1", [], {}, [1.0], float("nan"), float("inf"), -float("inf"), 10**400, 1 + 0j, b"1"]


def test_no_number_is_anything_else() -> None:
    for path in NUMBERS:
        for value in (*WRONG, -1.0, -1, 1e999):
            if path == ("upper",) and value is None:
                continue
            with pytest.raises(Malformed):
                contents(_changed(path, value))


def test_a_whole_number_is_one() -> None:
    for path in NUMBERS:
        if path[-1] == "case":
            for value in (0.0, 0.5, 2, 10**6, 10**30):
                with pytest.raises(Malformed):
                    contents(_changed(path, value))


HEX_WRONG = [
    *("nan", "inf", "-inf", "0x1p+9999", "0x1p+1024", "0x1p+200", "1.0", "", " 0x1p+0", "0x1p+0 ", "0x1p+0\n"),
    *("0X1P+0", "0x1P+0", "+0x1p+0", "0x1p0", "0x1", "0x2p+0", "0x1.00000000000000p+0", "0x1p+00000", "0x١p+0"),
    *("0x１p+0", "--0x1p+0", "0x1.gp+0", "0x1_0p+0", 0.0, 1, True, None, [], {}, float("nan")),
]


def test_no_hexadecimal_number_is_anything_else() -> None:
    for number, path in enumerate(HEXES):
        # All of them at some places, and some of them at all.
        for value in HEX_WRONG if number % 9 == 0 else HEX_WRONG[number % 7 :: 7]:
            with pytest.raises(Malformed):
                contents(_changed(path, value))


def test_what_may_not_be_negative_is_not() -> None:
    for path in HEXES:
        if path[0] in ("mbar", "cases", "statements") and {"mbar", "mass", "armature", "slack", "armature_lower"} & {
            *path
        }:
            with pytest.raises(Malformed):
                contents(_changed(path, "-0x1p-30"))
    for path in HEXES:
        if path[0] == "mbar":
            with pytest.raises(Malformed):
                contents(_changed(path, "0x0p+0"))


def test_zero_with_a_sign_is_zero() -> None:
    for path in HEXES:
        if _at(_whole(), path) == "0x0.0p+0":
            assert contents(_changed(path, "-0x0.0p+0")) == contents(_whole())


@pytest.mark.filterwarnings("error")
def test_huge_numbers_are_refused_without_a_warning() -> None:
    for path in HEXES:
        for value in ("0x1.fffffffffffffp+1023", "-0x1.fffffffffffffp+1023", "0x1p+101"):
            with pytest.raises(Malformed):
                contents(_changed(path, value))


def test_no_object_has_a_key_more_or_less() -> None:
    for path in OBJECTS:
        whole = _whole()
        _at(whole, path)["another"] = 0
        with pytest.raises(Malformed):
            contents(whole)
        for key in list(_at(_whole(), path)):
            if key == "k":
                continue
            whole = _whole()
            del _at(whole, path)[key]
            with pytest.raises(Malformed):
                contents(whole)


def test_no_list_or_object_is_anything_else() -> None:
    for path, value in FIELDS.items():
        if isinstance(value, (dict, list)):
            for other in (0, "text", True, None, [None], {"a": None}, [[]], 1.5):
                if path[-1] == "payload" and other is None:
                    continue
                with pytest.raises(Malformed):
                    contents(_changed(path, other))


def test_no_row_has_a_number_more_or_less() -> None:
    for path, value in FIELDS.items():
        if isinstance(value, list) and value and isinstance(value[0], str):
            for other in (value[:-1], [*value, value[0]], value * 40, []):
                with pytest.raises(Malformed):
                    contents(_changed(path, other))
        elif isinstance(value, list) and "sample_mass" in path:
            for other in (value[:-1], [*value, value[0]]):
                with pytest.raises(Malformed):
                    contents(_changed(path, other))


@pytest.mark.parametrize(
    ("path", "value"),
    [
        (("condition",), "Lemma1"),
        (("condition",), "weighted"),
        (("verdict",), "valid"),
        (("statements", 0, "kind"), "weighted"),
        (("statements", 0, "kind"), "lemma1"),
        (("statements", 1, "kind"), "level"),
        (("statements", 0, "level"), 1.0),
        (("statements", 0, "level"), 0.0),
        (("statements", 1, "level"), 0.5),
        (("statements", 0, "scale"), 0.0),
        (("level",), 0.0),
        (("level",), 1.0000001),
        (("upper",), 0.0),
        (("upper",), 1.0000001),
        (("joints",), ["a", "a"]),
        (("joints",), ["", "b"]),
        (("joints",), ["a" * 1001, "b"]),
        (("joints", 0), "\ud800"),
        (("arm",), "a" * 100_001),
        (("cases",), []),
        (("cases", 0, "lower"), hexed([1.1, 0.0])),
        (("cases", 0, "armature_lower"), hexed([0.1, 0.0])),
        (("cases", 0, "locked"), {"": "0x0p+0"}),
        (("cases", 0, "payload", "inertia"), hexed([0.01, 0, 0, 0.01, 0, 0.1])),
        (("cases", 0, "payload", "inertia"), hexed([-0.01, 0, 0, -0.01, 0, -0.01])),
        (("cases", 0, "payload", "mass"), "0x0p+0"),
    ],
)
def test_what_contradicts_itself_is_refused(path: tuple[Any, ...], value: Any) -> None:
    with pytest.raises(Malformed):
        contents(_changed(path, value))


def test_a_row_of_nothing_is_refused_with_what_is_expected() -> None:
    for key in ("armature", "slack"):
        with pytest.raises(Malformed, match=rf"statements\.0\.{key}: .*at least 1 item"):
            contents(_changed(("statements", 0, key), []))


def test_a_reason_is_one_line_that_can_be_printed() -> None:
    for key in ("\x1b[31m\n\u202e", "\ud800", "k" * 100_000):
        whole = _whole()
        whole["cases"][0]["locked"] = {key: "nan"}
        with pytest.raises(Malformed) as error:
            contents(whole)
        said = str(error.value)
        assert len(said) < 1000
        assert said.isprintable()
        said.encode()


# The URDF -----------------------------------------------------------------------------------------------------------


def _two(**changes: str) -> str:
    parts = {
        "base": link("base"),
        "a": link("a", inertial(2.0)),
        "b": link("b", inertial()),
        "j": joint("j", "base", "a"),
        "k": joint("k", "a", "b", axis="0 1 0"),
        **changes,
    }
    return robot(*parts.values())


def test_a_text_is_read_with_its_names_and_decimals() -> None:
    found = description(_two())
    assert (found.name, found.root, list(found.bodies)) == ("r", "base", ["base", "a", "b"])
    assert found.bodies["base"] is None
    assert found.bodies["a"] is not None
    assert (found.bodies["a"].mass, found.bodies["a"].pose.xyz) == ("2.0", ("0.1", "0", "0.02"))
    (first,) = found.children["base"]
    assert (first.name, first.kind, first.axis, first.pose.xyz) == (
        "j",
        "revolute",
        ("0", "0", "1"),
        ("0.1", "0", "0.3"),
    )


def _cut(text: str, old: str, new: str) -> str:
    assert old in text
    return text.replace(old, new, 1)


REFUSED: dict[str, Callable[[], str]] = {
    "no XML": lambda: "<robot",
    "a link without a name": lambda: _two(c=link(""), m=joint("m", "b", "")),
    "a joint without a name": lambda: _two(k=joint("", "a", "b")),
    "a name with a sign that cannot be shown": lambda: _two(k=joint("k&#x202e;", "a", "b")),
    "nothing": lambda: "",
    "nul": lambda: "<robot>\0</robot>",
    "a document type": lambda: "<!DOCTYPE robot>" + _two(),
    "a document type after a comment": lambda: "<!-- a --><!DOCTYPE robot SYSTEM 'file:///etc/passwd'>" + _two(),
    "entities": lambda: "<!DOCTYPE r [<!ENTITY a 'b'>]>" + _two(),
    "no links": lambda: "<robot name='r'/>",
    "two roots": lambda: _two(another=link("another")),
    "a circle": lambda: _two(j=joint("j", "b", "a")),
    "a circle beside the tree": lambda: _two(
        c=link("c"), d=link("d"), m=joint("m", "c", "d"), n=joint("n", "d", "c")
    ),
    "a joint from a link to itself": lambda: _two(c=link("c"), m=joint("m", "c", "c")),
    "a joint to the root": lambda: _two(m=joint("m", "b", "base")),
    "a diamond": lambda: _two(c=link("c"), m=joint("m", "base", "c"), n=joint("n", "c", "b")),
    "two links of one name": lambda: _two(b2=link("b")),
    "two joints of one name": lambda: _two(c=link("c"), m=joint("k", "a", "c")),
    "a joint to nowhere": lambda: _two(k=joint("k", "a", "c")),
    "a joint from nowhere": lambda: _two(k=joint("k", "c", "b")),
    "a joint without a parent": lambda: _cut(_two(), '<parent link="a"/>', ""),
    "a joint without a child": lambda: _cut(_two(), '<child link="b"/>', ""),
    "a joint with two parents": lambda: _cut(_two(), '<parent link="a"/>', '<parent link="base"/><parent link="a"/>'),
    "a joint with two axes": lambda: _cut(_two(), '<axis xyz="0 1 0"/>', '<axis xyz="1 0 0"/><axis xyz="0 1 0"/>'),
    "a link with two inertials": lambda: _two(b=link("b", inertial() + inertial())),
    "an inertial with two masses": lambda: _cut(_two(), "<mass", "<mass value='3'/><mass"),
    "a type that is none": lambda: _two(k=joint("k", "a", "b", kind="hinge")),
    "a joint in the plane": lambda: _two(k=joint("k", "a", "b", kind="planar")),
    "a free joint": lambda: _two(k=joint("k", "a", "b", kind="floating")),
    "an effort that is a word": lambda: _two(k=joint("k", "a", "b", extra=LIMIT.replace("50", "universe"))),
    "a velocity of two numbers": lambda: _two(k=joint("k", "a", "b", extra=LIMIT.replace('"3"', '"1 2"'))),
    "a limit that is no number": lambda: _two(k=joint("k", "a", "b", extra=LIMIT.replace("-2", "nan"))),
    "damping that is a word": lambda: _two(k=joint("k", "a", "b", extra=LIMIT + '<dynamics damping="some"/>')),
    "damping without end": lambda: _two(k=joint("k", "a", "b", extra=LIMIT + '<dynamics damping="inf"/>')),
    "friction without end": lambda: _two(k=joint("k", "a", "b", extra=LIMIT + '<dynamics friction="-inf"/>')),
    "no axis": lambda: _two(k=joint("k", "a", "b", axis="0 0 0")),
    "an axis that no float has": lambda: _two(k=joint("k", "a", "b", axis="0 1e-200 0")),
    "an axis of the last floats": lambda: _two(k=joint("k", "a", "b", axis="3e-320 1e-320 0")),
}  # fmt: skip


@pytest.mark.parametrize("what", REFUSED)
def test_a_text_that_is_no_tree_of_links_is_refused(what: str) -> None:
    with pytest.raises(Unreadable) as error:
        description(REFUSED[what]())
    assert str(error.value).isprintable()


def test_a_joint_may_turn_and_push_without_end() -> None:
    for old in ("-2", "50", "3"):
        endless = _two(k=joint("k", "a", "b", extra=LIMIT.replace(f'"{old}"', '"inf"')))
        assert "inf" in endless
        assert description(endless).children == description(_two(k=joint("k", "a", "b"))).children


NO_NUMBERS = [
    *("1e400", "-1e400", "1e31", "nan", "inf", "-inf", "0x1p3", "1_000", "１", "١", "1,5", "1e", "e5", ".", "+", "--1"),
    *("1e+-3", "1e1000", "1" * 401, "1 2", "½", "1\u00b2", "True", "1f", "1d0", "1e٣"),
]


@pytest.mark.parametrize("number", NO_NUMBERS)
def test_what_is_no_decimal_of_use_is_refused_wherever_it_stands(number: str) -> None:
    scalars = ('value="2.0"', 'ixx="0.01"', 'izz="0.015"')
    for old in (*scalars, 'xyz="0.1 0 0.02"', 'xyz="0.1 0 0.3"', 'rpy="0 0 0"', 'axis xyz="0 0 1"'):
        key, _, rest = old.partition('"')
        first = rest.strip('"').split()
        with pytest.raises(Unreadable):
            description(_cut(_two(), old, f'{key}"{" ".join([number, *first[1:]])}"'))


@pytest.mark.parametrize("number", ["1.", ".5", "+1", "-0", "1E2", "1e-60", "0e-999", "00012", "0." + "3" * 390])
def test_every_decimal_is_kept_as_it_is_written(number: str) -> None:
    body = description(_cut(_two(), 'value="2.0"', f'value="{number}"')).bodies["a"]
    assert body is not None
    assert body.mass == number


def test_a_wide_or_deep_text_is_read_in_a_moment() -> None:
    names = [f"l{k}" for k in range(2000)]
    deep = robot(*map(link, names), *(joint(f"j{k}", names[k], names[k + 1]) for k in range(1999)))
    assert len(description(deep).bodies) == 2000
    wide = robot(*map(link, names), *(joint(f"j{k}", names[0], names[k + 1]) for k in range(1999)))
    assert len(description(wide).children["l0"]) == 1999
    # Two ways from every link to the next would be 2^50 ways in all.
    ways = robot(*map(link, names[:50]), *(joint(f"j{k}{w}", names[k], names[k + 1]) for k in range(49) for w in "ab"))
    with pytest.raises(Unreadable, match="tree"):
        description(ways)


def test_a_joint_that_follows_another_is_not_moved_on_its_own() -> None:
    text = _two(k=joint("k", "a", "b", axis="0 1 0", extra=LIMIT + '<mimic joint="j"/>'))
    with pytest.raises(Unreadable, match="follows another"):
        chain_of(description(text), ["j", "k"], {}, None)
    assert chain_of(description(text), ["j"], {"k": 0.3}, None).parent.tolist() == [-1]


@pytest.mark.parametrize(
    ("joints", "locked", "why"),
    [
        (["j"], {}, "neither moves nor"),
        (["k"], {}, "neither moves nor"),
        (["j", "k", "l"], {}, "not the URDF's"),
        (["k", "j"], {}, "base first"),
        (["j", "k"], {"l": 0.0}, "locks joints"),
        (["j", "k"], {"k": 0.0}, "locks joints"),
        (["j"], {"k": 0.0, "l": 0.0}, "locks joints"),
    ],
)
def test_the_joints_of_a_certificate_are_all_that_the_text_moves(
    joints: list[str], locked: dict[str, float], why: str
) -> None:
    with pytest.raises(Unreadable, match=why):
        chain_of(description(_two()), joints, locked, None)


IMPOSSIBLE = {
    "a negative moment": np.diag([-0.01, 0.02, 0.02]),
    "a moment above the sum of the other two": np.diag([0.01, 0.02, 0.0301]),
    "a product that outweighs its moments": np.array([[0.02, 0.0, 0.03], [0.0, 0.02, 0.0], [0.03, 0.0, 0.02]]),
}


@pytest.mark.parametrize("what", IMPOSSIBLE)
def test_an_inertia_that_no_body_has_is_refused_even_where_no_joint_feels_it(what: str) -> None:
    """Joint j turns about z only: of link a, M(q) has the moment about z, and all the rest is never seen."""
    text = _two(a=link("a", inertial(2.0, com="3 0 0", inertia=IMPOSSIBLE[what])))
    with pytest.raises(Unreadable, match="no body has"):
        chain_of(description(text), ["j", "k"], {}, None)


def test_what_exporters_round_and_what_a_fixed_link_makes_up_for_is_an_inertia() -> None:
    rounded = _two(a=link("a", inertial(2.0, inertia=np.diag([0.01, 0.02, 0.03 * (1.0 + 3e-10)]))))
    dummy = _two(
        b2=link("b2", inertial(1e-8, com="0 0 0", inertia=np.diag([1e-8, 1e-8, 3e-8]))),
        fixed=joint("fixed", "b", "b2", kind="fixed"),
    )
    for text in (rounded, dummy):
        assert chain_of(description(text), ["j", "k"], {}, None).parent.tolist() == [-1, 0]


def test_a_joint_that_moves_no_mass_is_refused() -> None:
    with pytest.raises(Unreadable, match="no body has"):
        chain_of(description(_two(b=link("b"))), ["j", "k"], {}, None)


@pytest.mark.parametrize("name", arm_names())
def test_a_text_is_read_as_the_loader_reads_it(name: str) -> None:
    loaded = load_arm(name)
    found = description(loaded.urdf_text)
    joints = {joint.name: joint for on in found.children.values() for joint in on}
    moving = [joint.name for joint in joints.values() if joint.kind != "fixed"]
    assert set(moving) == {*loaded.joint_names, *loaded.locked}
    assert not any(joints[name].mimic for name in loaded.joint_names)
    chain = chain_of(found, loaded.joint_names, loaded.locked, None)
    q = np.random.default_rng(0).uniform(-3.0, 3.0, (5, loaded.nv))
    mass = loaded.mass_matrix(q)
    assert np.abs(chain.mass_matrix(q, loaded.armature) - mass).max() < 1e-13 * np.abs(mass).max()
