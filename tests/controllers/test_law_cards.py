"""The cards of the laws: what they say is asked of the step, and what they suggest holds three arms."""

from __future__ import annotations

import dataclasses
import json
import unicodedata
from functools import cache
from typing import Any

import numpy as np
import pytest
from law_oracles import run
from plant_cases import Waving

from asmc_pin.arms import Arm, load_arm
from asmc_pin.baselines import BASELINES
from asmc_pin.baselines.model_card import model_card, suggested_model_law
from asmc_pin.cli import main
from asmc_pin.controllers import CONTROLLERS, Ppc
from asmc_pin.controllers.law_card import cost_per_tick, law_card, reads_of, suggested
from asmc_pin.engine import rollout
from asmc_pin.plant import Friction, Plant
from asmc_pin.sampled.gain_warnings import gain_warnings
from asmc_pin.sampled.stable_ratios import stable_ratios, stable_words

pytestmark = pytest.mark.xdist_group("test_law_cards")  # they share what `cache` keeps

ARMS: dict[str, tuple[dict[str, Any], list[float], list[float]]] = {
    "two_link": ({}, [0.04, 0.03], [-1.2, 0.3]),
    "ur5": (
        {"armature": [0.5, 0.5, 0.3, 0.05, 0.05, 0.05]},
        [0.623, 0.877, 0.649, 0.262, 0.208, 0.0198],
        [0.3, -1.0, 1.2, 0.4, 0.8, 0.2],
    ),
    "panda": (
        {"armature": [0.3, 0.3, 0.3, 0.3, 0.1, 0.1, 0.1]},
        [0.596, 0.616, 0.554, 0.519, 0.145, 0.164, 0.081],
        [0.0, -0.4, 0.0, -2.0, 0.0, 1.6, 0.8],
    ),
}
"""Options, M̄ of the shipped experiments, and where the motion begins, rad."""

LAWS = list(CONTROLLERS)


@cache
def arm_of(name: str) -> Arm:
    return load_arm(name, **ARMS[name][0])


@pytest.mark.parametrize("arm", ARMS)
@pytest.mark.parametrize("name", LAWS)
def test_what_a_card_suggests_follows_a_motion_of_three_arms_under_friction(name: str, arm: str) -> None:
    _, mbar, start = ARMS[arm]
    law = suggested(CONTROLLERS[name], mbar=mbar)
    plant = Plant(arm_of(arm), friction=Friction(1.0, 0.3), effort_limit=np.inf)
    seen = rollout(plant, law, Waving(np.array(start), amplitude=0.2), 1.5)
    assert seen.status == ("ok",)
    assert np.abs(seen.q_ref - seen.q[0]).max() < 0.05


@pytest.mark.parametrize("arm", ARMS)
@pytest.mark.parametrize("name", BASELINES)
def test_what_a_card_of_a_law_with_a_model_suggests_follows_a_motion_of_three_arms(name: str, arm: str) -> None:
    law = suggested_model_law(name, arm_of(arm))
    plant = Plant(arm_of(arm), friction=Friction(1.0, 0.3), effort_limit=np.inf)
    seen = rollout(plant, law, Waving(np.array(ARMS[arm][2]), amplitude=0.2), 1.5)
    assert seen.status == ("ok",)
    assert np.abs(seen.q_ref - seen.q[0]).max() < 0.1


@pytest.mark.parametrize("name", BASELINES)
def test_a_card_of_a_law_with_a_model_is_complete_and_says_what_it_reads(name: str) -> None:
    card = model_card(name)
    assert all((card.equation, card.oracle, card.claim, card.fails, card.source))
    assert {"q", "v", "q_ref", "v_ref"} <= set(card.reads)
    assert ("torque" in card.reads) is (name == "slotine_li")  # what it was given says whether a limit was reached
    assert ("a_ref" in card.reads) is (name != "pd_gravity")
    assert ("remembers nothing" in card.diagram()[2]) is (name != "slotine_li")
    assert not [item for item in card.parameters if item.typical == "required"]


@pytest.mark.parametrize("arm", ARMS)
def test_what_a_card_suggests_is_stable_over_the_workspace_of_three_arms(arm: str) -> None:
    laws = {name: suggested(law, mbar=ARMS[arm][1]) for name, law in CONTROLLERS.items()}
    assert gain_warnings(arm_of(arm), laws) == []


@pytest.mark.parametrize("name", ["implicit", "dob", "adrc", "ppc"])
def test_the_limits_of_a_card_are_where_the_plant_becomes_unstable(name: str) -> None:
    law = suggested(CONTROLLERS[name], mbar=1.0)
    found = stable_ratios(law)
    assert found is not None
    for ratio, stable in ((0.98 * found[1], True), (1.03 * found[1], False)):
        trace = run(law, 1.0 / ratio, ticks=1200, load=np.zeros((1200, 1)), kicks=0.0, start=(1e-9, 1e-9))
        size = np.abs(trace.a[:, 0])
        assert bool(size[-200:].max() < size[200:400].max()) == stable


def test_the_limits_of_a_law_that_switches_are_those_of_the_ppc_in_it() -> None:
    ppc, ism = (stable_words(suggested(CONTROLLERS[name])) for name in ("ppc", "ism"))
    assert ism == f"near its set point it switches; the PPC in it is {ppc}"


def test_a_card_says_what_reaches_the_torque_and_what_is_remembered() -> None:
    adrc, pid, ppc = (law_card(name, CONTROLLERS[name]) for name in ("adrc", "pid", "ppc"))
    assert adrc.reads == ("q", "torque", "q_ref", "v_ref", "a_ref")  # from position only
    assert pid.reads == ("q", "v", "torque", "q_ref", "v_ref")
    assert set(ppc.reads) == {"q", "v", "torque", "q_ref", "v_ref", "a_ref"}
    assert adrc.remembers == ("position", "velocity", "load")


def test_what_a_law_reads_is_found_also_where_it_takes_a_little_of_it_for_noise() -> None:
    class Wary(Ppc):
        def step(self, state: Any, sample: Any, setpoint: Any) -> Any:
            return -sample.q - np.where(np.abs(sample.v) > 5.0, sample.v, 0.0), state

    assert reads_of(Wary(mbar=1.0, ks=8.0, beta=8.0, period=1e-3)) == ["q", "v"]


def test_what_a_tick_costs_is_taken_in_mid_run_from_a_state_that_the_law_gave() -> None:
    asked: list[Any] = []

    class Counting(Ppc):
        def step(self, state: Any, sample: Any, setpoint: Any) -> Any:
            asked.append(state)
            torque, _, state = self.pole_placement(state, sample, setpoint)
            return torque, state

    law = Counting(mbar=1.0, ks=8.0, beta=8.0, period=1e-3)
    assert cost_per_tick(law, 3, nv=2, seconds=1e-3) < 1.0
    assert [state.ticks for state in asked] == [0] + [1] * (len(asked) - 1)
    assert len(asked) > 20


@pytest.mark.parametrize("name", LAWS)
def test_a_card_is_complete_and_its_block_is_closed(name: str) -> None:
    card = law_card(name, CONTROLLERS[name])
    assert all((card.equation, card.oracle, card.claim, card.fails, card.source, card.remembers))
    required = {item.name for item in card.parameters if item.typical == "required"}
    assert not required
    assert set(CONTROLLERS[name].typical) <= {item.name for item in card.parameters}
    top, first, second, bottom = card.diagram()
    assert top.lstrip()[0] + top[-1] == "┌┐"
    assert bottom.lstrip()[0] + bottom[-1] == "└┘"
    assert first.endswith("│──> τ")
    assert second.endswith("│")
    left, right = top.index("┌"), top.index("┐")
    for line in (first.removesuffix("──> τ"), second, bottom):
        columns = [sign for sign in line if not unicodedata.combining(sign)]
        assert [k for k, sign in enumerate(columns) if sign in "│└┘"] == [left, right]


@pytest.mark.parametrize("name", LAWS)
def test_a_card_lists_a_law_s_own_parameters_under_their_heading_or_says_that_there_are_none(name: str) -> None:
    card = law_card(name, CONTROLLERS[name])
    lines = card.lines()
    assert lines[0] == f"{name}: {card.title}"
    if not card.parameters:
        assert "Parameters of its own: none" in lines
        return
    at = lines.index("Parameters of its own")
    assert [line.split(":")[0].strip() for line in lines[at + 1 : at + 1 + len(card.parameters)]] == [
        item.name for item in card.parameters
    ]


def test_nobody_changes_a_card_that_others_hold() -> None:
    card = law_card("barrier", CONTROLLERS["barrier"])
    for held in (card, card.parameters[0]):
        with pytest.raises(dataclasses.FrozenInstanceError):
            held.name = "another"  # type: ignore[misc]


def test_the_command_prints_a_card_with_what_a_tick_costs(capfd: pytest.CaptureFixture[str]) -> None:
    def asked(*more: str) -> tuple[Any, str, str]:
        with pytest.raises(SystemExit) as end:
            main(["controllers", *more])
        return end.value.code, *capfd.readouterr()

    status, out, _ = asked("barrier")
    assert status == 0
    assert "|s|/ε = n/(1 + n)" in out
    assert "µs at batch 1 and" in out
    status, out, _ = asked("barrier", "--json")
    found = json.loads(out)
    assert status == 0
    assert found["name"] == "barrier"
    assert found["microseconds"]["256"] > 0.0
    status, out, said = asked("barier")
    assert (status, out) == (2, "")
    assert "did you mean 'barrier'" in said
