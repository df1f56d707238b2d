"""Rewrite the generated tables of README.md; with --check, say whether they are fresh.

A table stands between ``<!-- begin NAME -->`` and ``<!-- end NAME -->``; the text around it is written by hand.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Callable
from pathlib import Path

from asmc_pin.disk.files import write_whole
from asmc_pin.words.media import for_cell

README = Path(__file__).resolve().parent.parent / "README.md"


def _table(header: list[str], rows: list[list[str]]) -> str:
    lines = [map(for_cell, header), ["---"] * len(header), *([for_cell(str(cell)) for cell in row] for row in rows)]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def arms() -> str:
    """One row per named arm."""
    from asmc_pin.cli.commands.listing_commands import arm_rows

    return _table(*arm_rows())


def controllers() -> str:
    """One row per control law."""
    from asmc_pin.cli.commands.listing_commands import controller_rows

    return _table(*controller_rows())


def metrics() -> str:
    """One row per metric."""
    from asmc_pin.cli.commands.listing_commands import metric_rows

    return _table(*metric_rows())


TABLES: dict[str, Callable[[], str]] = {"arms": arms, "controllers": controllers, "metrics": metrics}


def rendered(text: str) -> str:
    """The README's text with every table made anew."""
    for name, make in TABLES.items():
        pattern = re.compile(rf"(<!-- begin {name} -->\n).*?(<!-- end {name} -->)", re.DOTALL)
        if not pattern.search(text):
            raise SystemExit(f"README.md has no place for the table '{name}'")
        table = make()
        text = pattern.sub(lambda match, table=table: match[1] + table + "\n" + match[2], text)
    return text


if __name__ == "__main__":
    old = README.read_text(encoding="utf-8")
    new = rendered(old)
    if "--check" in sys.argv:
        sys.exit(0 if new == old else "README.md is stale: run make docs")
    write_whole(README, new)
