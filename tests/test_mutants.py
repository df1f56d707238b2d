"""The lists of `make mutants` are about the code as it is; the campaign takes half an hour and runs on its own."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import pytest

HERE = Path(__file__).parent
ROOT = HERE.parent


def listed(file: str, key: str) -> list[dict[str, Any]]:
    return list(tomllib.loads((HERE / "mutants" / file).read_text(encoding="utf-8")).get(key, []))


def text_of(module: str) -> str:
    """A module's lines one after the other, without indentation."""
    return " ".join(line.strip() for line in (ROOT / module).read_text(encoding="utf-8").splitlines())


@pytest.mark.parametrize(("file", "key"), [("equivalents.toml", "equivalent"), ("by_hand.toml", "fault")])
def test_every_line_that_a_mutant_changes_is_there(file: str, key: str) -> None:
    gone = [each for each in listed(file, key) if each["was"] not in text_of(each["module"])]
    assert not gone


def test_every_equivalent_mutant_has_a_reason_and_is_named_once() -> None:
    names = [(each["module"], each["was"], each["becomes"]) for each in listed("equivalents.toml", "equivalent")]
    assert len(set(names)) == len(names)
    assert all(len(each["reason"].split()) > 4 for each in listed("equivalents.toml", "equivalent"))


def test_the_modules_and_tests_of_a_campaign_are_there() -> None:
    targets = tomllib.loads((HERE / "mutants" / "targets.toml").read_text(encoding="utf-8"))
    assert all(list(ROOT.glob(pattern)) for patterns in targets["parts"].values() for pattern in patterns)
    assert all((ROOT / path.split("::")[0]).exists() for paths in targets["judges"].values() for path in paths)
