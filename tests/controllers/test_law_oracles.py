"""Every oracle of docs/laws.md, through the plant; and that no law is without one."""

from __future__ import annotations

import pytest
from law_oracles import ORACLES, Oracle, of_law

from asmc_pin.controllers import CONTROLLERS

WITHOUT = {"bsmc"}  # tests/controllers/test_controllers_closed_loop.py has its oracle


@pytest.mark.parametrize("item", ORACLES, ids=lambda item: f"{item.law}: {item.property}")
def test_an_oracle_of_a_law_holds_through_the_plant(item: Oracle) -> None:
    assert abs(item.measure() - item.value) <= item.within


def test_every_law_has_an_oracle() -> None:
    assert {name for name in CONTROLLERS if not list(of_law(name))} == WITHOUT
