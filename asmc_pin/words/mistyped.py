"""What somebody meant who wrote no plain number, or no plain CSV: said back with how to write it."""

from __future__ import annotations

import math
import re
import shlex

from asmc_pin.words.text import as_number, printable

_UNITS: dict[str, tuple[float, str]] = {
    "s": (1.0, "s"),
    "ms": (1e-3, "s"),
    "us": (1e-6, "s"),
    "µs": (1e-6, "s"),
    "rad": (1.0, "rad"),
    "deg": (math.pi / 180.0, "rad"),
    "°": (math.pi / 180.0, "rad"),
    "m": (1.0, "m"),
    "cm": (1e-2, "m"),
    "mm": (1e-3, "m"),
    "kg": (1.0, "kg"),
    "g": (1e-3, "kg"),
    "%": (1e-2, "1"),
}
_RATES = {"hz": 1.0, "khz": 1e3}
_SPANS = {"": 1.0, "s": 1.0, "sec": 1.0, "m": 60.0, "min": 60.0, "h": 3600.0}
_WITH_UNIT = re.compile(r"\s*([-+0-9.eE]+?)\s*([a-zA-Zµ°%]+)\s*")


def no_number(text: str) -> str:
    """What was given in place of one number, and how it is written."""
    given = f"'{printable(text.strip())}'"
    if ";" in text:
        return f"{given} is not a number; values stand with commas between them: {_shown(text.replace(';', ','))}"
    if "," in text:
        return f"{given} are {text.count(',') + 1} values, one number expected; a decimal sign is a point"
    value, unit = _split(text)
    if value is not None and unit in _UNITS:
        factor, si = _UNITS[unit]
        meant = f"{factor * value:.6g}{_in(si)}"
        return f"{given} is not a plain number; units are left out here, and everything is in SI: {meant}"
    if value and unit.lower() in _RATES:
        rate = value * _RATES[unit.lower()]
        return f"{given} is not a plain number; a rate is {rate:g} in Hz, and as a period {1.0 / rate:.6g} in s"
    return f"{given} is not a number"


def seconds(text: str) -> float:
    """A span of time: s, or with its unit ``90s``, ``2m`` or ``2min``, ``1h``.

    Raises:
        ValueError: It is none; the message says how one is written.
    """
    try:
        return as_number(text)
    except ValueError:
        value, unit = _split(text)
        if value is None or unit not in _SPANS:
            raise ValueError(f"'{printable(text)}' is not a time; seconds expected, or 90s, 2m, 1h") from None
        return value * _SPANS[unit]


def other_separator(header: str, file: str) -> str | None:
    """What to say of a CSV whose header has another sign than the comma between its names; None where it has not.

    Args:
        header: Its first line.
        file: Its name, for the command that mends it.
    """
    name = shlex.quote(printable(file))
    for sign, called, mend in ((";", "';'", "'s/,/./g; s/;/,/g'"), ("\t", "tabs", r"'s/,/./g; s/\t/,/g'")):
        if sign in header and "," not in header:
            return (
                f"has {called} between its values, commas and decimal points expected; for a copy that has: "
                f"sed {mend} {name} > comma.csv"
            )
    return None


def _split(text: str) -> tuple[float | None, str]:
    found = _WITH_UNIT.fullmatch(text)
    if found is None:
        return None, ""
    try:
        return as_number(found[1]), found[2]
    except ValueError:
        return None, ""


def _in(unit: str) -> str:
    return "" if unit == "1" else f" in {unit}"


def _shown(text: str) -> str:
    return printable(text.replace(" ", ""))
