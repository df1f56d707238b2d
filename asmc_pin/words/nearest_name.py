"""What somebody meant who wrote a name that is not known: the nearest known ones, or all of them."""

from __future__ import annotations

import difflib
from collections.abc import Iterable

_MOST = 3
"""So many names are offered at most."""

_LIKENESS = 0.6
"""Below this share of letters in common, 0 to 1, a name is not near."""


def near_names(name: str, known: Iterable[str]) -> list[str]:
    """The known names near to a given one, the nearest first; capitals make no difference."""
    by_lower: dict[str, list[str]] = {}
    for each in known:
        by_lower.setdefault(each.lower(), []).append(each)
    close = difflib.get_close_matches(name.lower(), by_lower, n=_MOST, cutoff=_LIKENESS)
    return [each for key in close for each in by_lower[key]][:_MOST]


def nearest(name: str, known: Iterable[str], all_of: str = "known are") -> str:
    """Advice on a name that is not known: the nearest known ones, or where none is near all of them.

    Args:
        name: As it was given.
        known: All there are.
        all_of: What stands before all of them.
    """
    names = list(known)
    near = near_names(name, names)
    if near:
        return "did you mean " + " or ".join(f"'{each}'" for each in near) + "?"
    return f"{all_of} {', '.join(names)}" if names else "none is known here"
