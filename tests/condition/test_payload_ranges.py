"""Ranges of what an arm carries: its mass is covered by the ends, its place is looked at and not proven."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest

from asmc_pin.arms import load_arm
from asmc_pin.cli import main
from asmc_pin.condition import bounds, lemma1_norm, verify
from asmc_pin.condition.certificate import certify
from asmc_pin.condition.domain.payload_ranges import carrying
from asmc_pin.errors import ParameterError, ResultError
from asmc_pin.sampled import SampledLoop, certify_loop
from asmc_pin.sampled.frozen_arms import frozen_arms

LOAD: dict[str, Any] = {"mass": (0.0, 2.0), "link": "tool0", "com": [(-0.1, 0.1), 0.0, 0.05]}
MBAR = (0.15, 0.17, 0.15, 0.08, 0.09, 0.017)


def test_every_end_and_middle_of_a_place_is_looked_at_once() -> None:
    arm = load_arm("ur5")
    loads = [laden.payload for laden, _ in carrying(arm, LOAD)]
    assert [(load.mass, load.com) for load in loads if load is not None] == [
        (0.0, (-0.1, 0.0, 0.05)),
        (2.0, (-0.1, 0.0, 0.05)),
        (2.0, (0.0, 0.0, 0.05)),
        (2.0, (0.1, 0.0, 0.05)),
    ]
    both = {**LOAD, "mass": (1.0, 2.0), "inertia": (0.2, 0, 0, 0.2, 0, 0.2)}
    heavier = [laden.payload for laden, _ in carrying(arm, both)]
    assert [(load.mass, load.com[0], load.inertia[0]) for load in heavier if load is not None] == [
        (mass, x, 0.1 * mass) for x in (-0.1, 0.0, 0.1) for mass in (1.0, 2.0)
    ]
    assert len(carrying(arm, {**LOAD, "com": [(-0.1, 0.1)] * 3})) == 28
    assert len(carrying(arm, {**LOAD, "mass": 1.0, "com": [0.1, 0.0, 0.0]})) == 1


def test_the_least_inertia_may_be_that_of_the_middle_of_a_range_of_places() -> None:
    """A payload on both sides of the last axis: on the axis it adds least, which is what M̄ has to bear."""
    arm = load_arm("ur5")
    found = bounds(arm, payload={"mass": 2.0, "com": [(-0.1, 0.1), 0.0, 0.0]}, budget=1.0)
    ends = [bounds(arm, payload={"mass": 2.0, "com": (x, 0.0, 0.0)}, budget=1.0).lower.found for x in (-0.1, 0.1)]
    assert found.lower.found < 0.9 * min(ends)


def test_a_verdict_says_where_the_payload_was_looked_at() -> None:
    report = verify(load_arm("ur5"), MBAR, payload=LOAD, samples=256, starts=4)
    content = json.loads(json.dumps(report.to_json_dict()))
    assert content["payload"] == {"mass": [0.0, 2.0], "link": "tool0", "com": [[-0.1, 0.1], 0.0, 0.05]}
    assert any("the ends and the middle, not between" in line for line in report.lines())
    worst = content["worst_payload"]
    laden = load_arm("ur5", payload=worst)
    norm = float(lemma1_norm(laden.mass_matrix(report.worst_q), np.array(MBAR)))
    assert norm == pytest.approx(report.lower, rel=1e-9)


def test_a_range_of_places_is_searched_and_not_proven(tmp_path: Any) -> None:
    arm, small = load_arm("two_link"), {"mass": 0.01, "com": [(0.0, 0.05), 0.0, 0.0]}
    result = certify(arm, 0.01, payload=small, budget=5.0)
    assert (result.verdict, result.scale_proven, result.upper) == ("undecided", 0.0, None)
    assert "no proof covers a range of the payload's place" in result.reason
    with pytest.raises(ResultError):
        result.save(tmp_path / "proof.cert")
    assert certify(arm, 0.01, payload={**small, "com": (0.05, 0.0, 0.0)}, budget=20.0, levels=False).verdict == "holds"
    found = bounds(arm, payload=small, budget=5.0)
    assert (found.lower.proven, found.upper.proven, found.coriolis.proven) == (None, None, None)
    loop = SampledLoop(np.full(2, 0.01), 5.0, 5.0, 1e-3)
    proof = certify_loop(arm, loop, payload=small, budget=5.0)
    assert (proof.verdict, "no proof covers" in proof.reason) == ("undecided", True)


def test_a_loop_is_frozen_on_every_place_with_its_range_of_masses() -> None:
    arms = frozen_arms(load_arm("ur5"), payload=LOAD)
    ends = [tuple(arm.payload for arm in pair) for pair in arms.pairs]
    places = [(0.0, 2.0, x) for x in (-0.1, 0.0, 0.1)]
    assert [(light.mass, heavy.mass, heavy.com[0]) for light, heavy in ends] == places
    assert len(frozen_arms(load_arm("ur5"), payload=(0.0, 2.0)).pairs) == 1
    assert len(frozen_arms(load_arm("ur5"), payload={**LOAD, "mass": (1.0, 2.0)}).pairs) == 3
    assert len(frozen_arms(load_arm("ur5"), payload={**LOAD, "mass": 1.0}).pairs) == 3


@pytest.mark.parametrize(
    ("payload", "message"),
    [
        ({"mass": (2.0, 1.0)}, "payload.mass: the range 2:1 is empty"),
        ({"mass": (1.0, 2.0, 3.0)}, r"payload.mass: \(1.0, 2.0, 3.0\) given, a number or a range"),
        ({"mass": 1.0, "com": [(0.1, 0.0), 0.0, 0.0]}, "payload.com: the range 0.1:0 is empty"),
        ({"mass": 1.0, "com": [(0.0, 0.1), 0.0]}, "payload.com: .* given, 3 numbers or ranges"),
        ({"mass": 1.0, "com": [(0.0, float("nan")), 0.0, 0.0]}, "payload.com: .* given, a number or a range"),
        ({"com": [(0.0, 0.1), 0.0, 0.0]}, "payload.mass: None given"),
    ],
)
def test_a_range_that_is_none_is_refused(payload: Any, message: str) -> None:
    with pytest.raises(ParameterError, match=message):
        carrying(load_arm("ur5"), payload)


def test_the_command_line_takes_link_centre_and_inertia(capsys: pytest.CaptureFixture[str]) -> None:

    def verified(*options: str) -> int:
        with pytest.raises(SystemExit) as end:
            raise SystemExit(main(["verify", "ur5", "--mbar", mbar, "--samples", "64", "--json", *options]))
        return int(end.value.code or 0)

    mbar = ",".join(map(str, MBAR))
    inertia = ["--payload-inertia", "0.002,0,0,0.002,0,0.002"]
    assert verified("--payload", "0:0.2@tool0", "--payload-com", "0:0.02,0,0.05", *inertia) == 0
    content = json.loads(capsys.readouterr().out)["payload"]
    assert content["mass"] == [0.0, 0.2]
    assert (content["link"], content["com"]) == ("tool0", [[0.0, 0.02], 0.0, 0.05])
    assert (content["inertia"][0], content["inertia_lightest"][0]) == (0.002, 0.0)
    assert verified("--payload", "0:0.2") == 0
    assert "a point on the axis of joints 'wrist_2_joint', 'wrist_3_joint'" in capsys.readouterr().err
    for options, message in (
        (["--payload", "2@"], "'2@' names no link after '@'; write it like 2@tool0"),
        (["--payload-com", "0,0,0"], "'0,0,0' given without a payload; add --payload KG[@LINK]"),
        (["--payload", "2", "--payload-com", "0,0"], "'0,0' has 2 values, 3 expected"),
        (["--payload", "2", "--payload-inertia", "1"], "'1' has 1 values, 6 expected"),
    ):
        assert verified(*options) == 2
        assert message in capsys.readouterr().err
