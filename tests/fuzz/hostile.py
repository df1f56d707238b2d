"""What a stranger's file may hold: names, numbers, values, and changes to bytes and to nested data."""

from __future__ import annotations

import copy
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

Rng = np.random.Generator

INJECTED = "</script><fuzz>"
"""Stands in names; no page may hold it as it is."""

NAMES = (
    "plain",
    "joint_1",
    "gelenk_ä",
    "関節",
    "🤖",
    "e\u0301",
    "[/joint_1]",
    "[bold]x",
    "[link=http://x]y",
    INJECTED,
    "<b>&amp;",
    '" onload="x',
    "{0}",
    "%s%n",
    "$x_1$",
    r"\input{x}",
    "a|b",
    "a`b*c_d",
    "\x1b[31mred",
    "\x9b31m",
    "\x07bell",
    "line\nbreak",
    "line\u2028break",
    "cr\rreturn",
    "\u202egnp.exe",
    "\u2066a\u2069",
    "\u200b",
    "\ufeff",
    "\udcff",
    "\x00",
    "",
    " ",
    "a b",
    " led",
    "=1+1",
    "nan",
    "None",
    "-x",
    "--json",
    "../../x",
    "/dev/null",
    "universe",
    "root_joint",
    "__joint__:j0",
    "a" * 300,
)

NUMBERS = (
    *("0", "-0", "1", "-1", "1e-3", "1e-8", "1e-14", "1e-300", "5e-324", "1e-400", "1e8", "1e16", "1e154", "1e300"),
    *("1.7976931348623157e308", "1e400", "-1e300", "nan", "inf", "-inf", "NaN", "0x10", "1_0", "1,5", "", " ", " 1 "),
    *("1 2", "one", "\uff11", "--1", "1d3", ".5", "5.", "+1", "1e", "9" * 400, "0." + "3" * 400, "3.141592653589793"),
)

VALUES: tuple[Any, ...] = (
    *(None, True, False, 0, 1, -1, 2, 10**6, 2**31, 2**63, 10**30, 0.0, -0.0, 0.5, 1e-12, 5e-324, 1e300),
    *(float("nan"), float("inf"), float("-inf"), "", "0x1p0", "0x1p-1074", "0x1p1023", "0x1p99999", "nan", "inf"),
    *([], {}, [[]], [0.1], [0.1, 0.2], [1.0] * 7, [[0.1, 0.2], [0.3, 0.4]], {"a": 1}, ["a"], [None], [True], [{}]),
)


def pick(rng: Rng, items: Sequence[Any]) -> Any:
    """One of them."""
    return items[int(rng.integers(len(items)))]


def chance(rng: Rng, share: float) -> bool:
    """Whether this one is among the share."""
    return bool(rng.random() < share)


def name(rng: Rng) -> str:
    """Any of the names, or two joined, or a long one now and then."""
    if chance(rng, 0.005):
        return "n" * int(rng.choice([5_000, 100_000]))
    return str(pick(rng, NAMES)) + (str(pick(rng, NAMES)) if chance(rng, 0.1) else "")


def number(rng: Rng) -> str:
    """A number, or what is none."""
    return str(pick(rng, NUMBERS)) if chance(rng, 0.7) else repr(float(rng.normal() * 10.0 ** rng.uniform(-12, 12)))


def value(rng: Rng) -> Any:
    """Anything that JSON or TOML can hold."""
    if chance(rng, 0.2):
        return name(rng)
    if chance(rng, 0.3):
        return float(rng.normal() * 10.0 ** rng.uniform(-6, 3))
    if chance(rng, 0.01):
        deep: Any = 1
        for _ in range(int(rng.choice([20, 500, 5_000]))):
            deep = [deep] if chance(rng, 0.5) else {"a": deep}
        return deep
    return copy.deepcopy(pick(rng, VALUES))


def mutate_bytes(rng: Rng, data: bytes, other: bytes = b"") -> bytes:
    """A few changes to bytes: flipped, cut out, doubled, put in, cut off, or taken from another file."""
    made = bytearray(data)
    for _ in range(int(rng.geometric(0.4))):
        at = int(rng.integers(len(made) + 1))
        end = min(len(made), at + int(rng.geometric(0.05)))
        how = int(rng.integers(8))
        if how <= 1 and made:
            made[min(at, len(made) - 1)] ^= 1 << int(rng.integers(8))
        elif how == 2:
            del made[at:end]
        elif how == 3:
            made[at:at] = made[at:end] * int(rng.choice([1, 2, 50]))
        elif how == 4:
            made[at:at] = rng.bytes(int(rng.integers(1, 20)))
        elif how == 5:
            made[at:end] = b"\x00" * (end - at)
        elif how == 6 and chance(rng, 0.3):
            del made[at:]
        elif how == 7 and other:
            cut = int(rng.integers(len(other)))
            made[at:end] = other[cut : cut + int(rng.integers(1, 200))]
    return bytes(made)


def slots(tree: Any) -> Iterator[tuple[Any, Any]]:
    """Every container of nested data with each of its keys or places."""
    waiting = [tree]
    while waiting:
        at = waiting.pop()
        for key in list(at) if isinstance(at, dict) else range(len(at)) if isinstance(at, list) else ():
            yield at, key
            waiting.append(at[key])


FACTORS = (-1.0, 0.0, 1e-6, 0.5, 0.9, 1.0 + 1e-12, 1.001, 1.1, 2.0, 10.0, 1e3, 1e9)


def scale_number(rng: Rng, tree: Any) -> None:
    """Multiply one number of nested data, in place."""
    numbers = [(h, k) for h, k in slots(tree) if isinstance(h[k], int | float) and not isinstance(h[k], bool)]
    if numbers:
        holder, key = pick(rng, numbers)
        made = holder[key] * float(pick(rng, FACTORS))
        holder[key] = made if isinstance(holder[key], float) or not np.isfinite(made) else int(made)


def mutate_tree(rng: Rng, tree: Any, other: Any = None) -> None:
    """One change to nested lists and dictionaries, in place."""
    places = list(slots(tree))
    if not places:
        return
    holder, key = pick(rng, places)
    how = int(rng.integers(9))
    if how <= 2:
        holder[key] = value(rng)
    elif how == 3:
        del holder[key]
    elif how == 4:
        scale_number(rng, tree)
    elif how == 5:
        there, from_key = pick(rng, places)
        holder[key] = copy.deepcopy(there[from_key])
    elif how == 6 and isinstance(holder, dict):
        holder[name(rng) if chance(rng, 0.5) else f"{key}_"] = holder.pop(key) if chance(rng, 0.5) else value(rng)
    elif how == 7 and isinstance(holder, list):
        holder.insert(int(rng.integers(len(holder) + 1)), copy.deepcopy(holder[key]))
    elif other is not None:
        like = [(h, k) for h, k in slots(other) if k == key]
        if like:
            there, from_key = pick(rng, like)
            holder[key] = copy.deepcopy(there[from_key])
