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


def test_operators_delete_terms_factors_statements_and_magnitudes() -> None:
    pytest.importorskip("cosmic_ray", reason="make mutants installs it")
    from cosmic_ray.mutating import mutate_code
    from mutants.operators import operators

    def made(operator: str, code: str) -> list[str]:
        found: list[str] = []
        while (text := mutate_code(code, operators()[operator], len(found))) is not None:
            found.append(text)
        return found

    assert made("DropTerm", "x = a - b + c\n") == ["x = (- b + c)\n", "x = (a + c)\n", "x = (a - b)\n"]
    assert made("DropFactor", "x = a / b * c\n") == ["x = (a * c)\n", "x = (a / b)\n"]
    assert made("DropStatement", "x[0] = 1\ny = 2\nx += 1\nf(x)\n") == [
        "pass\ny = 2\nx += 1\nf(x)\n",
        "x[0] = 1\ny = 2\npass\nf(x)\n",
        "x[0] = 1\ny = 2\nx += 1\npass\n",
    ]
    assert made("SwapCall", "x = abs(a) + np.min(b)\n") == ["x = (a) + np.min(b)\n", "x = abs(a) + np.max(b)\n"]
