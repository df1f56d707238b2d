"""Names, numbers and comments as C99 has them, good for C++ as well."""

from __future__ import annotations

import math
import re

import numpy as np

from asmc_pin.errors import AsmcPinError
from asmc_pin.words.choices import RealType

LARGEST: dict[RealType, float] = {"double": float(np.finfo(np.float64).max), "float": float(np.finfo(np.float32).max)}
"""The largest finite number of a type."""

_TAKEN = frozenset(
    """alignas alignof and and_eq asm auto bitand bitor bool break case catch char class compl complex const constexpr
    const_cast continue decltype default delete do double dynamic_cast else enum errno explicit export extern false
    float for friend goto if imaginary inline int linux long mutable namespace new noexcept not not_eq nullptr operator
    or or_eq private protected public register reinterpret_cast restrict return short signed sizeof static
    static_assert static_cast struct switch template this thread_local throw true try typedef typeid typename union
    unix unsigned using virtual void volatile wchar_t while xor xor_eq""".split()  # noqa: SIM905
)
"""Words that are no names in C99, C++ or a compiler's own dialect."""


class NotInC(AsmcPinError):
    """Something that has no counterpart here in C; the message says what, where, and what to write instead."""


def identifier(name: str) -> str:
    """A Python name as a C name; a word of C or C++ gets an underscore behind it."""
    if not re.fullmatch(r"[A-Za-z_][A-Za-z0-9_]*", name):
        raise NotInC(f"the name '{name}' has letters that C99 does not know; use a to z, 0 to 9 and _")
    return f"{name}_" if name in _TAKEN else name


def slug(text: str) -> str:
    """Any text as the end of a C name: small letters, digits and single underscores."""
    return re.sub(r"[^a-z0-9]+", "_", text.lower()).strip("_") or "unnamed"


def literal(value: float, real: RealType) -> str:
    """A finite number as a literal that is read back as that number, to the last bit of the type."""
    rounded = float(np.float32(value)) if real == "float" else float(value)
    if not math.isfinite(rounded):
        raise NotInC(f"the number {value!r} is not finite as {real}; give a value that is")
    text = str(np.float32(rounded)) if real == "float" else repr(rounded)
    if not any(mark in text for mark in ".e"):
        text += ".0"
    return text + ("f" if real == "float" else "")


def comment(text: str) -> str:
    """Text that may stand in a C comment, on as many lines as it has."""
    safe = text.replace("*/", "* /").replace("/*", "/ *").replace("??", "? ?").replace("\\", "/")
    return "".join(c if c == "\n" or c.isprintable() else " " for c in safe)
