"""Ranges of what an arm carries: its mass is covered by the ends, its place is looked at and not proven."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest

from asmc_pin.arms import load_arm
from asmc_pin.cli import main
from asmc_pin.condition import bounds, lemma1_norm, verify, weighted_norm
from asmc_pin.condition.certificate import certify
from asmc_pin.condition.domain.arm_ranges import cases
from asmc_pin.condition.domain.payload_ranges import carrying
from asmc_pin.condition.domain.places_between import corners
from asmc_pin.errors import ParameterError, ResultError
from asmc_pin.rigid_body.mass_matrix import mass_matrices
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


@pytest.mark.long
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
    assert any("what is proven holds between too" in line for line in report.lines())
    worst = content["worst_payload"]
    laden = load_arm("ur5", payload=worst)
    norm = float(lemma1_norm(laden.mass_matrix(report.worst_q), np.array(MBAR)))
    assert norm == pytest.approx(report.lower, rel=1e-9)


@pytest.mark.parametrize("seed", range(4))
def test_inertia_between_places_is_a_mix_of_the_corners_that_are_proven(seed: int) -> None:
    rng = np.random.default_rng(seed)
    low, high = -rng.random(3), rng.random(3)
    if seed:
        high[rng.integers(3)] = low[0]  # a range along some axes only
        low, high = np.minimum(low, high), np.maximum(low, high)
    inertia = (0.2, 0.01, 0.0, 0.3, 0.0, 0.25)
    com = [(a, b) if a < b else a for a, b in zip(low.tolist(), high.tolist(), strict=True)]
    arm = load_arm("ur5")
    mass = {"mass": (0.5, 2.0), "link": "tool0", "com": com, "inertia": inertia}
    found = cases(arm, payload=mass)
    proven = corners(found)
    q, place, load = rng.uniform(-3.0, 3.0, arm.nv), rng.uniform(low, high), float(rng.uniform(0.5, 2.0))
    scaled = tuple(load / 2.0 * x for x in inertia)
    ours = load_arm("ur5", payload={"mass": load, "link": "tool0", "com": tuple(place), "inertia": scaled})
    width = np.where(high > low, high - low, 1.0)
    upper, spread = (
        (place - low) / width,
        np.where(high > low, (place - low) * (high - place) / (0.5 * width) ** 2, 0.0),
    )
    total = np.zeros((arm.nv, arm.nv))
    weights = 0.0
    for corner in proven:
        payload = found[corner.case].domain.arm.payload
        assert payload is not None
        at_high = (np.array(payload.com) == high) & (high > low)
        weight = np.prod(np.where(high > low, np.where(at_high, upper, 1.0 - upper), 1.0))
        weight *= (load - 0.5) / 1.5 if payload.mass == 2.0 else (2.0 - load) / 1.5
        # How much of the second moments is taken off at this corner tells which it is.
        off = np.array([corner.tree.inertia[k] - found[corner.case].domain.arm.tree.inertia[k] for k in range(6)]).sum(
            axis=0
        )
        turned = arm.model.frames[arm.model.getFrameId("tool0")].placement.rotation
        second = -turned.T @ off @ turned
        share = (0.5 * np.trace(second) - np.diag(second)) / payload.mass / (0.5 * width) ** 2
        weight *= np.prod(np.where(high > low, np.where(share > 0.5, spread, 1.0 - spread), 1.0))
        total += weight * mass_matrices(corner.tree, q[None])[0]
        weights += weight
    assert weights == pytest.approx(1.0)
    assert total == pytest.approx(ours.mass_matrix(q), abs=1e-10)


@pytest.mark.parametrize("condition", ["weighted", "lemma1"])
def test_a_range_of_places_is_proven_with_all_that_lies_between(condition: Any, tmp_path: Any) -> None:
    arm, small = load_arm("two_link"), {"mass": (0.0, 0.05), "com": [(-0.1, 0.2), 0.0, (0.0, 0.1)]}
    result = certify(arm, 0.01, condition=condition, payload=small, gap=0.3, budget=20.0, levels=False)
    assert result.scale_proven > 0.0
    norm = weighted_norm if condition == "weighted" else lemma1_norm
    rng = np.random.default_rng(1)
    for _ in range(60):
        com = (float(rng.uniform(-0.1, 0.2)), 0.0, float(rng.uniform(0.0, 0.1)))
        laden = load_arm("two_link", payload={"mass": float(rng.uniform(0.0, 0.05)), "com": com})
        mass = laden.mass_matrix(rng.uniform(*arm.box, (200, arm.nv)))
        assert norm(mass, result.scale_proven * np.array(result.mbar)).max() < 1.0
    with pytest.raises(ResultError, match="ranges of a payload's place are in no certificate"):
        result.save(tmp_path / "proof.cert")


def test_bounds_and_a_loop_over_places_are_proven_but_for_forces_and_gravity() -> None:
    arm, small = load_arm("two_link"), {"mass": 0.05, "com": [(-0.1, 0.1), 0.0, 0.0]}
    found = bounds(arm, payload=small, gap=0.3, budget=20.0)
    assert found.lower.proven is not None
    assert found.upper.proven is not None
    assert found.coriolis.proven is None
    assert any("no c is proven over a range of the payload's place" in note for note in found.notes)
    rng = np.random.default_rng(2)
    for x in rng.uniform(-0.1, 0.1, 40):
        laden = load_arm("two_link", payload={"mass": 0.05, "com": (float(x), 0.0, 0.0)})
        values = np.linalg.eigvalsh(laden.mass_matrix(rng.uniform(*arm.box, (200, arm.nv))))
        assert found.lower.proven < values.min()
        assert values.max() < found.upper.proven
    proof = certify_loop(arm, SampledLoop(np.full(2, 0.01), 5.0, 5.0, 1e-3), payload=small, budget=20.0)
    assert (proof.verdict, proof.gravity) == ("stable", None)
    assert "range of the payload's place" in proof.no_gravity


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
