"""What `certify` promises: bounds on both sides, verdicts, ranges, levels, and something to say whenever it stops."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from arm_urdf import inertial, joint, link, robot, write
from certificate_cases import UR5_WEIGHTED, norms, ur5_certificate
from condition_cases import UR5_MBAR, chain

from asmc_pin import load_arm
from asmc_pin._typing import Array
from asmc_pin.arms import Arm
from asmc_pin.condition import CONDITIONS, search_worst, verify
from asmc_pin.condition.certificate import ProofProgress, certify
from asmc_pin.condition.certificate.search_and_proof import certified
from asmc_pin.errors import ArmError, ParameterError
from asmc_pin.references import Ramps


@pytest.fixture(scope="module")
def ur5() -> Arm:
    return load_arm("ur5")


def test_the_weighted_condition_is_proven_on_the_bare_ur5_within_one_percent(ur5: Arm) -> None:
    found = ur5_certificate()
    assert found.verdict == "holds"
    assert 1.0 < found.scale_proven < found.scale_refuted
    assert found.gap <= 0.01
    # A level below 1 as well, and between what was seen and 1.
    assert found.upper is not None
    assert found.lower < found.upper < 1.0
    norm = search_worst(ur5, np.array(UR5_WEIGHTED), "weighted", seed=7)[0]
    assert norm == pytest.approx(found.lower, abs=1e-9)
    assert norms("weighted")(ur5.mass_matrix(found.worst_q), np.array(UR5_WEIGHTED)) == pytest.approx(norm, abs=1e-9)


def test_lemma_1_is_proven_on_the_bare_ur5(ur5: Arm) -> None:
    found = certify(ur5, UR5_MBAR, gap=0.05, budget=60.0, levels=False)
    assert (found.verdict, found.upper) == ("holds", 1.0)
    assert found.scale_proven >= 0.95 * found.scale_refuted
    # Just above the scale that is refuted the norm is above 1 there, and just below the scale proven it is nowhere.
    mass = ur5.mass_matrix(found.refuted_q)
    assert norms("lemma1")(mass, 1.001 * found.scale_refuted * np.array(UR5_MBAR)) > 1.0
    assert search_worst(ur5, found.scale_proven * np.array(UR5_MBAR), seed=3)[0] < 1.0


def test_two_joints_are_decided_within_a_thousandth_with_one_box() -> None:
    for condition in CONDITIONS:
        found = certify(load_arm("double_pendulum"), 0.01, condition=condition, gap=0.001, budget=20.0)
        assert found.gap <= 0.001
        assert found.boxes == 1


@pytest.mark.parametrize("condition", CONDITIONS)
def test_twice_what_is_refuted_is_violated_and_the_counter_example_shows_it(ur5: Arm, condition: str) -> None:
    mbar = 2.2 * np.array(UR5_WEIGHTED)
    found = certify(ur5, mbar, condition=condition, gap=0.2, budget=10.0)  # type: ignore[arg-type]
    assert found.verdict == "violated"
    assert found.scale_refuted <= 1.0
    assert found.upper is None
    assert found.lower >= 1.0
    assert norms(condition)(ur5.mass_matrix(found.worst_q), mbar) == pytest.approx(found.lower)


def test_the_scale_proven_on_a_box_holds_on_every_part_of_it(ur5: Arm) -> None:
    found = ur5_certificate()
    rng = np.random.default_rng(0)
    for _ in range(5):
        centre, half = rng.uniform(-2.5, 2.5, 6), rng.uniform(0.05, 0.5, 6)
        part = centre - half, centre + half
        inside = certify(ur5, UR5_WEIGHTED, condition="weighted", box=part, gap=0.05, budget=5.0, levels=False)
        assert inside.scale_refuted > found.scale_proven


def test_what_it_says_is_right_whenever_it_stops(ur5: Arm) -> None:
    seen: list[ProofProgress] = []

    def stop(progress: ProofProgress) -> None:
        seen.append(progress)
        if progress.proven > 0.0 and progress.trying.startswith("scale"):
            raise KeyboardInterrupt

    rough = certify(load_arm("panda"), 0.004, condition="weighted", gap=1e-4, budget=30.0, progress=stop, threads=1)
    assert rough.reason == "interrupted"
    assert 0.0 < rough.scale_proven == seen[-1].proven
    assert rough.history[-1][1] == rough.scale_proven
    assert search_worst(load_arm("panda"), rough.scale_proven * rough.mbar, "weighted", samples=4096)[0] < 1.0
    short = certify(load_arm("panda"), UR5_MBAR[0], gap=1e-4, budget=1e-3)
    assert short.verdict in ("violated", "undecided")
    assert short.scale_proven < short.scale_refuted
    assert short.reason == "out of time"


def test_one_thread_and_two_prove_the_same(ur5: Arm) -> None:
    one, two = (
        certify(ur5, UR5_WEIGHTED, condition="weighted", gap=0.02, threads=k, levels=False, budget=30.0) for k in (1, 2)
    )
    assert one.scale_proven == two.scale_proven
    assert one.boxes == two.boxes
    assert [p.record.tolist() for p in one.proofs] == [p.record.tolist() for p in two.proofs]


def test_a_payload_range_is_proven_by_its_ends(ur5: Arm) -> None:
    mbar = 0.8 * np.array(UR5_WEIGHTED)
    found = certify(ur5, mbar, condition="weighted", payload=(0.0, 5.0), gap=0.05, budget=30.0)
    assert found.verdict == "holds"
    assert len(found.cases) == 2
    assert found.upper is not None
    for load in (0.7, 2.0, 4.1):
        norm, _ = search_worst(ur5.replace(payload=load), mbar, "weighted", samples=4096)
        assert norm < found.upper


@pytest.mark.parametrize("condition", CONDITIONS)
def test_an_armature_range_is_proven_by_its_ends(condition: str) -> None:
    arm = load_arm("double_pendulum")
    ranges: list[float | tuple[float, float]] = [(0.05, 0.3), 0.02]
    found = certify(arm, (0.06, 0.02), condition=condition, armature=ranges, gap=0.02, budget=10.0)  # type: ignore[arg-type]
    assert found.verdict == "holds"
    assert found.upper is not None
    assert found.upper < 1.0
    for first in (0.05, 0.11, 0.3):
        held = arm.replace(armature=[first, 0.02])
        assert search_worst(held, np.array((0.06, 0.02)), condition)[0] < found.upper + 1e-12  # type: ignore[arg-type]


def test_many_armature_ranges_are_bounded_together(ur5: Arm) -> None:
    # 2⁶ ends would be 64 proofs; one lower bound of them all takes their place, and is one.
    found = certify(ur5, UR5_MBAR, armature=(0.2, 0.21), gap=0.3, budget=30.0)
    assert found.verdict == "holds"
    levels = [proof.statement for proof in found.proofs if proof.statement.kind == "level"]
    assert len(levels) == 1
    assert levels[0].slack == pytest.approx(np.full(6, 0.01))
    for armature in (0.2, 0.204, 0.21):
        assert search_worst(ur5.replace(armature=armature), np.array(UR5_MBAR))[0] < levels[0].level


def test_every_choice_of_a_locked_joint_is_proven(ur5: Arm) -> None:
    mbar = np.array(UR5_WEIGHTED)[:5]
    found = certify(ur5, mbar, condition="weighted", lock={"wrist_3_joint": (0.0, 1.0)}, gap=0.1, budget=30.0)
    assert found.joints == ur5.joint_names[:5]
    assert [case.label for case in found.cases] == ["wrist_3_joint locked at 0", "wrist_3_joint locked at 1"]
    assert found.verdict == "holds"


def test_a_level_is_decided_on_its_own(ur5: Arm) -> None:
    at = {"condition": "weighted", "budget": 20.0}
    inside = certify(ur5, UR5_WEIGHTED, level=0.96, **at)  # type: ignore[arg-type]
    assert (inside.verdict, inside.upper) == ("holds", 0.96)
    assert "< 0.96" in inside.formula
    outside = certify(ur5, UR5_WEIGHTED, level=0.93, **at)  # type: ignore[arg-type]
    assert outside.verdict == "violated"
    assert outside.lower > 0.93


def test_sliding_and_branched_arms_are_proven_too(tmp_path: Path) -> None:
    sliding = chain(tmp_path, 4, 4, prismatic=True)
    branched = load_arm(
        write(
            tmp_path,
            robot(
                link("base"),
                link("body", inertial(3.0)),
                link("left", inertial(1.0)),
                link("hand", inertial(0.5)),
                link("right", inertial(1.5)),
                joint("waist", "base", "body"),
                joint("l", "body", "left", axis="0 1 0", xyz="0 0.2 0.3"),
                joint("h", "left", "hand", axis="1 0 0", xyz="0.2 0 0"),
                joint("r", "body", "right", "prismatic", axis="1 0 0", xyz="0 -0.2 0.3"),
            ),
        )
    )
    for arm in (sliding, branched):
        q = np.random.default_rng(0).uniform(*arm.box, (500, arm.nv))
        mbar = np.full(arm.nv, 0.9 * np.linalg.eigvalsh(arm.mass_matrix(q)).min())
        for condition in CONDITIONS:
            found = certify(arm, mbar, condition=condition, gap=0.05, budget=20.0)
            assert found.gap <= 0.05
            assert found.verdict == "holds"
            assert found.upper is not None
            assert found.lower < found.upper < 1.0


def test_one_joint_is_exact(tmp_path: Path) -> None:
    arm = load_arm(write(tmp_path, robot(link("base"), link("arm", inertial(2.0)), joint("only", "base", "arm"))))
    m = float(arm.mass_matrix(np.zeros(1))[0, 0])
    found = certify(arm, m, condition="weighted", gap=1e-6, budget=10.0)
    assert found.scale_refuted == pytest.approx(2.0, abs=1e-6)
    assert found.scale_proven == pytest.approx(2.0, abs=1e-5)


def test_the_report_joins_the_search_and_the_proof(ur5: Arm) -> None:
    report = certified(verify(ur5, UR5_WEIGHTED, condition="weighted", samples=256, starts=2), ur5_certificate())
    content = report.to_json_dict()
    assert json.loads(json.dumps(content))["scale_proven"] == ur5_certificate().scale_proven
    assert content["kind"] == "certified"
    assert content["verdict"] == "holds"
    own = ur5_certificate().to_json_dict()
    assert {key: own[key] for key in ("verdict", "upper", "scale_refuted")} == {
        key: content[key] for key in ("verdict", "upper", "scale_refuted")
    }


@pytest.mark.parametrize(
    ("options", "named"),
    [
        ({"gap": 0.0}, "gap"),
        ({"gap": float("nan")}, "gap"),
        ({"budget": -1.0}, "budget"),
        ({"threads": 0}, "threads"),
        ({"level": 1.5}, "level"),
        ({"box": {"elbow": (0.0, 1.0)}}, "elbow"),
        ({"box": {"elbow_joint": (1.0, 0.0)}}, "empty"),
        ({"condition": "lemma"}, "condition"),
        ({"mbar": [0.1, 0.2]}, "6"),
        ({"mbar": [-0.1] * 6}, "positive"),
        ({"mbar": [float("nan")] * 6}, "mbar"),
        ({"armature": (0.2, 0.1)}, "armature"),
    ],
)
def test_bad_input_is_refused_in_one_sentence(ur5: Arm, options: dict[str, object], named: str) -> None:
    mbar = options.pop("mbar", UR5_MBAR)
    with pytest.raises(ParameterError, match=named) as caught:
        certify(ur5, mbar, **options)  # type: ignore[arg-type]
    assert "\n" not in str(caught.value)


def test_a_slide_without_a_range_is_refused(tmp_path: Path) -> None:
    free = joint("rail", "base", "body", "prismatic", extra='<limit effort="1" velocity="1"/>')
    arm = load_arm(write(tmp_path, robot(link("base"), link("body", inertial()), free)))
    with pytest.raises(ArmError, match="rail"):
        certify(arm, 0.1)


def test_a_proof_of_a_full_turn_is_of_one_turn(ur5: Arm) -> None:
    # The UR5's joints turn twice; M repeats itself, so the proof is over one turn and says so.
    lower, upper = ur5_certificate().cases[0].domain.box.lower, ur5_certificate().cases[0].domain.box.upper
    assert upper - lower == pytest.approx(np.full(6, 2.0 * np.pi))
    wide: Array = np.asarray(ur5.upper - ur5.lower)
    assert np.all(wide > 2.0 * np.pi)


def test_a_tube_around_a_motion_is_proven_slice_by_slice() -> None:
    arm = load_arm("xarm7", armature=[0.5, 0.5, 0.3, 0.3, 0.05, 0.05, 0.05])
    lower, upper = arm.box
    middle = 0.5 * (lower + upper)
    motion = Ramps(points=[middle.tolist(), (middle + 0.15 * (upper - lower)).tolist()], times=[0.0, 2.0])
    mbar = np.array([0.6, 0.6, 0.4, 0.4, 0.06, 0.09, 0.05])
    options = {"along": motion, "tube_width": 0.5, "slices": 6}
    found = certify(arm, mbar, gap=0.2, budget=30.0, **options)  # type: ignore[arg-type]
    assert found.scope == "tube"
    assert len(found.cases) == 6
    assert found.scale_proven >= 0.8 * found.scale_refuted
    # Anywhere within half a radian of the motion, and there a larger M̄ than over the whole box.
    rng = np.random.default_rng(0)
    q = motion.evaluate(rng.uniform(0.0, 2.0, 300)).q + rng.uniform(-0.5, 0.5, (300, 7))
    assert norms("lemma1")(arm.mass_matrix(q), found.scale_proven * mbar).max() < 1.0
    report = certified(verify(arm, mbar, samples=600, starts=4, **options), found)  # type: ignore[arg-type]
    assert (report.kind, report.scope, report.scale_proven) == ("certified", "tube", found.scale_proven)
    with pytest.raises(ParameterError, match="tube"):
        certify(arm, mbar, along=motion)
    with pytest.raises(ParameterError, match="domain"):
        certified(verify(arm, mbar, samples=64, starts=1), found)
