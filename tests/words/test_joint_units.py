"""A table of an arm with a slide says kilograms and metres there, and nobody else's table changes."""

from __future__ import annotations

import pytest
from arm_urdf import write
from urdf_kinds import KINDS

from asmc_pin import Arm, design, load_arm, stability, verify
from asmc_pin.words.joint_units import column_cells, column_head, listed_with_units
from asmc_pin.words.text import counted


def test_one_unit_stands_in_the_head_and_two_stand_at_the_figures() -> None:
    assert column_head("m̄", "inertia", (False, False)) == "m̄ kg·m²"
    assert column_cells(["1", "2"], "inertia", (False, False)) == ["1", "2"]
    assert column_head("m̄", "inertia", (False, True)) == "m̄"
    assert column_cells(["1", "2"], "inertia", (False, True)) == ["1 kg·m²", "2 kg"]
    assert column_head("worst q", "place", (True, True)) == "worst q m"
    assert listed_with_units(["1", "2"], "place", (True, False)) == "(1 m, 2 rad)"
    assert listed_with_units(["1", "2"], "place", (True, True)) == "(1, 2) m"


@pytest.fixture(scope="module")
def scara(tmp_path_factory: pytest.TempPathFactory) -> Arm:
    return load_arm(write(tmp_path_factory.mktemp("scara"), KINDS["scara"].text))


def test_a_slide_has_kilograms_and_metres_in_every_table(scara: Arm) -> None:
    mbar = [0.05, 0.02, 0.001, 0.5]
    checked = verify(scara, mbar, samples=64)
    loop = stability(scara, mbar, 20.0, 20.0, 0.001, limits=False)
    found = design(scara, budget=5.0)
    for report in (checked, loop, found):
        table = report.table()
        assert table is not None
        head, rows = table
        at = next(k for k, name in enumerate(head) if name.startswith("m̄"))
        place = next(k for k, name in enumerate(head) if name.startswith("worst q"))
        assert rows[0][at].endswith(" kg·m²")
        assert rows[0][place].endswith(" rad")
        assert rows[3][at].endswith(" kg")
        assert rows[3][place].endswith(" m")
    assert "0.5 kg), K_s" in str(loop)


def test_one_thing_is_counted_as_one() -> None:
    assert [counted(n, "box", "boxes") for n in (0, 1, 2)] == ["0 boxes", "1 box", "2 boxes"]
    assert [counted(n, "link") for n in (1, 3)] == ["1 link", "3 links"]
