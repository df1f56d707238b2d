"""docs/extending.md does what it says: each addition is carried out in a copy, and what holds for its kind is asked."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest
from paths import REPOSITORY

BLOCK = re.compile(r"^```\w+\n(.*?)^```$", re.DOTALL | re.MULTILINE)
PLACE = re.compile(
    r"(?:New file|In) `([^`]+)`(?:,\s+(after|before)\s+the\s+line\s+of\s+`([^`]+)`|,\s+(at the end))?:\s*$"
)
SECTIONS = {
    part.split("\n", 1)[0]: part.split("\n", 1)[1]
    for part in re.split(
        r"^## ", (REPOSITORY / "docs" / "extending.md").read_text(encoding="utf-8"), flags=re.MULTILINE
    )[1:]
}

# What holds for everything of a kind, and what a page or a file of the copy then says.
CHECKS = {
    "A law": (["tests/controllers", "-k", "super_twisting or documented"], ["README.md", "docs/controllers.md"]),
    "A reference kind": (["tests/references/test_references.py"], ["docs/references.md"]),
    "An arm": (
        ["tests/arms/test_physics.py", "tests/arms/test_arms.py", "-k", "one_link"],
        ["README.md", "docs/arms.md"],
    ),
    "A metric": (["tests/test_metrics.py"], ["README.md", "docs/metrics.md"]),
    "A friction term": (
        ["tests/plant/test_plant_friction_models.py", "-k", "term or pulled or sticks_up or refused"],
        ["docs/plant.md"],
    ),
    "A figure": (["tests/pages/test_report_tables.py", "-k", "every_figure"], ["docs/experiments.md"]),
    "A command": (["tests/cli/test_cli.py", "-k", "list or version or bad_input"], ["docs/rooms.md"]),
    "An experiment key": (
        ["tests/experiment/test_experiment.py", "-k", "path_of_its_key or valid_under"],
        ["docs/experiments.md"],
    ),
    "A public name": (["tests/test_public_api.py", "-k", "every_public_name or loads_nothing or signature"], []),
}


def steps(section: str) -> tuple[list[tuple[re.Match[str], str]], str]:
    """The additions of a section, each with its place, and the code that then holds."""
    found = []
    then = ""
    for block in BLOCK.finditer(section):
        before = section[: block.start()].rstrip()
        if before.endswith("What then holds:"):
            then = block[1]
            continue
        place = PLACE.search(" ".join(before[-300:].split()))
        assert place, f"no place is said above:\n{block[1]}"
        found.append((place, block[1]))
    return found, then


def carry_out(place: re.Match[str], text: str, copy: Path) -> None:
    """Put a block where it belongs."""
    path = copy / place[1]
    if place[0].startswith("New file"):
        assert not path.exists()
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
        return
    lines = path.read_text(encoding="utf-8").splitlines(keepends=True)
    if place[4]:
        at = len(lines)
        text = f"\n\n{text}"
    else:
        (at, *_) = (i for i, line in enumerate(lines) if place[3] in line)
        text = textwrap.indent(text, re.match(" *", lines[at])[0])
        at += place[2] == "after"
    path.write_text("".join([*lines[:at], text, *lines[at:]]), encoding="utf-8")


def run(copy: Path, *command: str) -> str:
    done = subprocess.run(
        [sys.executable, *command],
        cwd=copy,
        env={**os.environ, "PYTHONPATH": str(copy)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout[-6000:] + done.stderr[-3000:]
    return done.stdout


@pytest.fixture
def copy(tmp_path: Path) -> Path:
    """The checkout without what git does not keep."""
    kept = subprocess.run(
        ["git", "ls-files", "-co", "--exclude-standard"], cwd=REPOSITORY, capture_output=True, text=True
    )
    for name in kept.stdout.splitlines():
        source = REPOSITORY / name
        if source.is_file():
            target = tmp_path / "copy" / name
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(source, target)
    return tmp_path / "copy"


def test_every_kind_of_addition_has_its_section_and_its_checks() -> None:
    assert list(SECTIONS) == list(CHECKS)
    table = (REPOSITORY / "CONTRIBUTING.md").read_text(encoding="utf-8")
    assert re.findall(r"^\| (an? [a-z ]+) \|", table, re.MULTILINE) == [
        name[:1].lower() + name[1:] for name in SECTIONS
    ]


@pytest.mark.parametrize("name", SECTIONS)
def test_an_addition_costs_no_more_than_one_place_and_one_line(name: str) -> None:
    places, then = steps(SECTIONS[name])
    assert then
    whole = [place for place, text in places if place[0].startswith("New file")]
    changed = {place[1] for place, _ in places if place not in whole and place[1].startswith("asmc_pin/")}
    assert len(changed) <= 1
    if whole:
        assert sum(text.count("\n") for place, text in places if place[1] in changed) <= 1


@pytest.mark.long
@pytest.mark.parametrize("name", SECTIONS)
def test_an_addition_as_the_page_has_it_passes_what_holds_for_its_kind(name: str, copy: Path) -> None:
    asked, pages = CHECKS[name]
    before = {page: (copy / page).read_text(encoding="utf-8") for page in pages}
    places, then = steps(SECTIONS[name])
    for place, text in places:
        carry_out(place, text, copy)
    run(copy, "-c", f"import asmc_pin; assert asmc_pin.__file__.startswith({str(copy)!r})\n{then}")
    run(copy, "-m", "ruff", "format", "--quiet", "asmc_pin", "tests")
    run(copy, "-m", "ruff", "check", "asmc_pin", "tests")
    run(copy, "docs/generate.py")
    for page, text in before.items():
        assert (copy / page).read_text(encoding="utf-8") != text, f"{page} says nothing of it"
    for tests in (["tests/test_layering.py"], asked):
        told = run(copy, "-m", "pytest", "-q", "-n", "0", "-p", "no:cacheprovider", *tests)
        assert " passed" in told
    run(copy, "docs/generate.py", "--check")
