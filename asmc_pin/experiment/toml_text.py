"""Reading TOML with errors that name the line, and writing back what the standard library can only read."""

from __future__ import annotations

import json
import math
import re
import tomllib
from collections.abc import Mapping
from datetime import date, time
from pathlib import Path
from typing import Any

from asmc_pin.disk.reading import read_file
from asmc_pin.disk.reading import shown as shown_path
from asmc_pin.errors import ExperimentError
from asmc_pin.words.text import printable

LARGEST = 5_000_000
"""Bytes of an experiment file at most; a motion of more points belongs into a CSV file."""

_DEEPEST, _MOST_KEYS = 40, 5_000
# tomllib takes the square of a dotted key's length in time.
_DOTTED, _SEPARATORS = re.compile(r"""[\w"'-]\s*\."""), re.compile(r"[=,\[\]{}\n]")
_BARE_KEY = re.compile(r"[A-Za-z0-9_-]+")


def parse_toml(text: str, origin: str) -> dict[str, Any]:
    """Parse TOML.

    Args:
        text: The file's text.
        origin: What to call the file in an error.

    Raises:
        ExperimentError: the TOML is broken; names the line, and shows it.
    """
    if any(len(_DOTTED.findall(piece)) > _DEEPEST for piece in _SEPARATORS.split(text)):
        raise ExperimentError("", f"{origin} is not valid TOML here: a key of more than {_DEEPEST} parts")
    try:
        data = tomllib.loads(text)
    except RecursionError:
        raise ExperimentError("", f"{origin} is not valid TOML here: values in one another too deep to read") from None
    except tomllib.TOMLDecodeError as error:
        # "Expected '=' after a key in a key/value pair (at line 3, column 5)"
        match = re.fullmatch(r"(.*) \(at (?:line (\d+), column (\d+)|end of document)\)", str(error), re.DOTALL)
        if match is None:
            raise ExperimentError("", f"{origin} is not valid TOML: {error}") from None
        lines = text.splitlines() or [""]
        line = int(match[2]) if match[2] else len(lines)
        shown = lines[min(line, len(lines)) - 1].strip()
        raise ExperimentError("", f"{origin} is not valid TOML, line {line}: {match[1]}: {shown}") from None
    except ValueError as error:  # an integer of thousands of digits
        raise ExperimentError("", f"{origin} is not valid TOML: {error}") from None
    _check_values(data, origin)
    return data


def _check_values(data: dict[str, Any], origin: str) -> None:
    """Refuse what TOML, or its reader, allows and no key of an experiment means."""
    left: list[tuple[str, int, Any]] = [("", 0, data)]
    keys = 0
    while left:
        path, depth, container = left.pop()
        keys += len(container) if isinstance(container, dict) else 0
        if keys > _MOST_KEYS:
            raise ExperimentError("", f"{origin}: has more than {_MOST_KEYS} keys; no experiment has as many")
        if depth > _DEEPEST:
            raise ExperimentError("", f"{origin}: {printable(path)}: values in one another more than {_DEEPEST} deep")
        for key, value in container.items() if isinstance(container, dict) else enumerate(container):
            if isinstance(value, str | float):  # most values, and a list may have a million
                continue
            place = f"{path}.{key}".lstrip(".") if isinstance(container, dict) else f"{path}[{key}]"
            if isinstance(value, dict | list):
                left.append((place, depth + 1, value))
            elif isinstance(value, date | time):
                raise ExperimentError("", f"{origin}: {printable(place)}: a date or a time; an experiment has none")
            elif isinstance(value, int) and not -(2**63) <= value < 2**63:
                raise ExperimentError("", f"{origin}: {printable(place)}: an integer of more than TOML's 64 bits")


def read_toml(path: Path) -> tuple[str, dict[str, Any]]:
    """Text and content of a TOML file."""
    data = read_file(path, LARGEST, "an experiment", lambda message: ExperimentError("", message))
    try:
        text = data.decode("utf-8")
    except UnicodeDecodeError as error:
        raise ExperimentError(
            "", f"{shown_path(path)} is not text in UTF-8 (byte {error.start}); an experiment is a TOML file"
        ) from None
    return text, parse_toml(text, shown_path(path))


def write_toml(data: Mapping[str, Any]) -> str:
    """TOML text of nested tables of text, numbers, booleans and lists; ``parse_toml`` gives the same data back."""
    lines: list[str] = []
    _write_table(lines, (), data)
    return "\n".join(lines).lstrip("\n") + "\n"


def _write_table(lines: list[str], path: tuple[str, ...], table: Mapping[str, Any]) -> None:
    plain = {key: value for key, value in table.items() if not isinstance(value, Mapping) and value is not None}
    nested = {key: value for key, value in table.items() if isinstance(value, Mapping)}
    if path and (plain or not nested):
        lines += ["", "[" + ".".join(map(_key, path)) + "]"]
    lines += [f"{_key(key)} = {toml_value(value)}" for key, value in plain.items()]
    for key, value in nested.items():
        _write_table(lines, (*path, key), value)


def _key(key: str) -> str:
    return key if _BARE_KEY.fullmatch(key) else _text(key)


def _text(value: str) -> str:
    # JSON's escapes are TOML's; it leaves DEL as it is, which TOML does not allow.
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")


def toml_value(value: Any) -> str:
    """A value as TOML, on one line."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float):
        return repr(value) if math.isfinite(value) else str(value)
    if isinstance(value, int):
        return str(value)
    if isinstance(value, str):
        return _text(value)
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(toml_value(item) for item in value) + "]"
    if isinstance(value, Mapping):  # in a list
        return "{ " + ", ".join(f"{_key(key)} = {toml_value(item)}" for key, item in value.items()) + " }"
    raise TypeError(f"cannot write {value!r} as TOML")
