"""Rewrite what README.md, CONTRIBUTING.md and docs/ derive from the code; with --check, say whether it is fresh.

What is derived stands between ``<!-- begin NAME -->`` and ``<!-- end NAME -->``, NAME as in `derived_parts.PARTS`; the
text around it is written by hand. Files that are derived as a whole stand in `WHOLE`.
"""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import site_parts  # noqa: F401  (registers parts)
from derived_parts import PARTS
from rooms_drawing import rooms_svg

from asmc_pin.disk.files import write_whole
from asmc_pin.experiment import experiment_schema_text

ROOT = Path(__file__).resolve().parent.parent
WHOLE: dict[str, Callable[[], str]] = {
    "docs/images/rooms.svg": rooms_svg,
    "experiments/experiment.schema.json": experiment_schema_text,
}
_PART = re.compile(r"(<!-- begin ([\w-]+) -->\n).*?(<!-- end \2 -->)", re.DOTALL)


def pages() -> list[Path]:
    """Every page in which a part may stand."""
    return sorted([*ROOT.glob("*.md"), *(ROOT / "docs").glob("*.md"), *(ROOT / "docs" / "howto").glob("*.md")])


def parts_of(text: str) -> list[str]:
    """Names of the parts in a page; a beginning without its end is an error."""
    found = [match[2] for match in _PART.finditer(text)]
    begun = re.findall(r"<!-- (?:begin|end) ([\w-]+) -->", text)
    if sorted(begun) != sorted(found * 2):
        raise SystemExit(f"a part has a beginning or an end alone: {', '.join(sorted(set(begun)))}")
    return found


def rendered(text: str) -> str:
    """A page with every part made anew."""
    for name in parts_of(text):
        if name not in PARTS:
            raise SystemExit(f"there is no part '{name}'; known are {', '.join(PARTS)}")
    return _PART.sub(lambda match: match[1] + PARTS[match[2]]() + "\n" + match[3], text)


def everything() -> Iterator[tuple[Path, str]]:
    """Every derived file and its text as it should be."""
    for path in pages():
        text = path.read_text(encoding="utf-8")
        if parts_of(text):
            yield path, rendered(text)
    for name, make in WHOLE.items():
        yield ROOT / name, make()


def stale() -> list[Path]:
    """The derived files that are not as they should be."""
    return [path for path, text in everything() if not path.is_file() or path.read_text(encoding="utf-8") != text]


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--check", action="store_true", help="write nothing; exit status 1 where a file is stale")
    if parser.parse_args().check:
        names = [str(path.relative_to(ROOT)) for path in stale()]
        sys.exit(f"run make docs; stale: {', '.join(names)}" if names else 0)
    for path, text in everything():
        write_whole(path, text)
