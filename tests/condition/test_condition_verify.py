"""Verifying M̄ by search: it finds what is there, over boxes, ranges and motions, and says no more than it knows."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from condition_cases import UR5_MBAR, chain

from asmc_pin import Setpoint, load_arm, verify
from asmc_pin.arms import Arm
from asmc_pin.condition import CONDITIONS, lemma1_norm, scale_refuted, search_worst, weighted_norm
from asmc_pin.condition.domain.along_motion import motion_of, tube
from asmc_pin.condition.domain.joint_box import resolve_box
from asmc_pin.errors import ArmError, ParameterError

KEYS = (
    "arm sha256 joints mbar armature payload locked box scope condition level verdict kind lower upper "
    "worst_q worst_payload worst_armature configurations seconds"
)


@dataclass(frozen=True)
class Swing:
    """joint_1 over ±160°, joint_2 over ±60°."""

    duration: float = 2.0
    nv: int = 2

    def evaluate(self, t: np.ndarray) -> Setpoint:
        q = np.stack((np.radians(160) * np.sin(np.pi * t), np.radians(60) * np.sin(np.pi * t)), axis=-1)
        return Setpoint(q, 0.0 * q, 0.0 * q)


@pytest.fixture(scope="module")
def two_link() -> Arm:
    return load_arm("two_link")


@pytest.fixture(scope="module")
def ur5() -> Arm:
    return load_arm("ur5")


def test_two_links_paper_range_within_sixty_degrees_and_over_a_full_turn(two_link: Arm) -> None:
    inside = verify(two_link, 0.01, box={"joint_2": (-np.pi / 3, np.pi / 3)})
    assert (round(inside.smallest, 4), round(inside.lower, 4)) == (0.9869, 0.9886)
    turn = verify(two_link, 0.01)
    assert (round(turn.smallest, 3), round(turn.lower, 4)) == (0.978, 0.9886)
    # 0.9886 is 1 − m̄/λ_max(M) with the arm stretched out.
    stretched = np.linalg.eigvalsh(two_link.mass_matrix(np.zeros(2)))[-1]
    assert turn.lower == pytest.approx(1.0 - 0.01 / stretched, abs=1e-12)
    assert np.abs(turn.worst_q[1]) < 1e-4


def test_ur5s_known_mbar_has_the_norm_0_968_whatever_the_seed(ur5: Arm) -> None:
    for seed in range(4):
        norm, q = search_worst(ur5, np.array(UR5_MBAR), seed=seed, samples=4096)
        assert norm == pytest.approx(0.96829389935, abs=1e-9)
        assert lemma1_norm(ur5.mass_matrix(q), np.array(UR5_MBAR)) == pytest.approx(norm, abs=1e-12)


@pytest.mark.parametrize("condition", CONDITIONS)
def test_search_finds_at_least_what_a_dense_grid_finds(tmp_path: Path, condition: str) -> None:
    norm_of = {"lemma1": lemma1_norm, "weighted": weighted_norm}[condition]
    for seed in range(3):
        arm = chain(tmp_path, seed, 4, prismatic=seed == 2)
        lower, upper = arm.box
        axes = [np.linspace(lower[i], upper[i], 31) for i in (1, 2, 3)]
        grid = np.stack(np.meshgrid([0.0], *axes, indexing="ij"), axis=-1).reshape(-1, 4)
        mass = arm.mass_matrix(grid)
        for share in (0.5, 5.0):
            mbar = np.full(4, share * np.linalg.eigvalsh(mass).min())
            found, q = search_worst(arm, mbar, condition, samples=2048)
            assert found >= norm_of(mass, mbar).max() - 1e-12
            assert np.all(q >= lower)
            assert np.all(q <= upper)


@pytest.mark.parametrize("name", ["ur5", "panda", "z1", "kinova", "xarm7", "double_pendulum"])
def test_mean_diagonal_guess_is_refuted_on_real_arms(name: str) -> None:
    arm = load_arm(name)
    mass = arm.mass_matrix(np.random.default_rng(0).uniform(*arm.box, (200, arm.nv)))
    guess = np.diagonal(mass, axis1=1, axis2=2).mean(axis=0)
    report = verify(arm, guess, samples=2048)
    assert report.verdict == "violated"
    assert report.lower > 5.0
    assert lemma1_norm(arm.mass_matrix(report.worst_q), guess) == pytest.approx(report.lower, rel=1e-9)


@pytest.mark.parametrize("condition", CONDITIONS)
def test_refuted_scale_is_where_the_condition_breaks(ur5: Arm, condition: str) -> None:
    mbar = np.array(UR5_MBAR)
    factor, q = scale_refuted(ur5, mbar, condition, samples=4096)
    norm_of = {"lemma1": lemma1_norm, "weighted": weighted_norm}[condition]
    mass = ur5.mass_matrix(q)
    assert norm_of(mass, mbar * factor * (1 - 1e-9)) < 1.0 < norm_of(mass, mbar * factor * (1 + 1e-9))
    assert search_worst(ur5, mbar * factor * 0.999, condition, samples=4096)[0] < 1.0


def test_refuted_scale_is_zero_where_no_multiple_satisfies_lemma1() -> None:
    # M at the worst configuration couples the joints so that NM + MN is indefinite for this ratio of m̄.
    arm = load_arm("double_pendulum")
    factor, q = scale_refuted(arm, np.array([1.0, 1000.0]), samples=1024)
    assert factor == 0.0
    assert lemma1_norm(arm.mass_matrix(q), np.array([1e-9, 1e-6])) >= 1.0


def test_payload_ends_cover_the_masses_between(ur5: Arm) -> None:
    report = verify(ur5, np.array(UR5_MBAR), payload=(0.0, 3.0), samples=4096)
    for mass in (0.5, 1.5, 2.5):
        assert search_worst(ur5.replace(payload=mass), np.array(UR5_MBAR), samples=4096)[0] <= report.lower + 1e-12
    assert report.worst_case == "payload 3 kg"


def test_armature_ends_cover_the_values_between(ur5: Arm) -> None:
    mbar = np.array(UR5_MBAR)
    report = verify(ur5, mbar, armature=[(0.0, 0.1)] * 3 + [0.0, 0.01, (0.0, 0.05)], samples=4096)
    ranged = [0, 1, 2, 5]
    assert np.isin(report.worst_armature[ranged], [0.0, 0.1, 0.05]).all()
    assert report.worst_armature[4] == 0.01
    rng = np.random.default_rng(0)
    for _ in range(5):
        inside = rng.uniform(0, 1, 6) * [0.1, 0.1, 0.1, 0.0, 0.0, 0.05] + [0, 0, 0, 0, 0.01, 0]
        assert search_worst(ur5.replace(armature=inside), mbar, samples=2048)[0] <= report.lower + 1e-12


def test_every_choice_of_a_locked_joint_is_verified(ur5: Arm) -> None:
    mbar = np.array(UR5_MBAR)[:5]
    both = verify(ur5, mbar, lock={"wrist_3_joint": [0.0, 1.0]}, samples=2048)
    each = [verify(ur5, mbar, lock={"wrist_3_joint": angle}, samples=2048).lower for angle in (0.0, 1.0)]
    assert both.lower == max(each)
    assert both.joints == ur5.joint_names[:5]


def test_norm_along_a_motion_is_the_norm_at_its_configurations(two_link: Arm) -> None:
    report = verify(two_link, 0.01, along=Swing())
    assert (round(report.smallest, 4), round(report.lower, 4)) == (0.9869, 0.9886)
    assert report.times is not None
    assert report.norms is not None
    expected = lemma1_norm(two_link.mass_matrix(Swing().evaluate(report.times).q), np.full(2, 0.01))
    np.testing.assert_allclose(report.norms, expected, rtol=1e-12)
    assert report.norms[np.searchsorted(report.times, report.worst_time)] == report.lower


def test_a_tube_holds_its_motion_and_is_held_by_the_box(ur5: Arm) -> None:
    @dataclass(frozen=True)
    class Wave:
        duration: float = 1.0

        def evaluate(self, t: np.ndarray) -> Setpoint:
            q = 0.5 * np.sin(np.outer(t, np.arange(1.0, 7.0)))
            return Setpoint(q, q, q)

    mbar = np.array(UR5_MBAR)
    line = verify(ur5, mbar, along=Wave())
    narrow = verify(ur5, mbar, along=Wave(), tube_width=0.05, slices=8)
    wide = verify(ur5, mbar, along=Wave(), tube_width=0.5, slices=8)
    assert line.lower <= narrow.lower <= wide.lower <= verify(ur5, mbar).lower + 1e-12
    motion = motion_of(Wave(), 6)
    for part in tube(motion, 0.05, 8):
        inside = motion.q[(motion.times >= part.start) & (motion.times <= part.end)]
        assert np.all((inside >= part.lower + 0.05 - 1e-12) & (inside <= part.upper - 0.05 + 1e-12))


def test_report_is_the_same_for_the_same_seed_and_says_sampled(ur5: Arm) -> None:
    first, second = (verify(ur5, np.array(UR5_MBAR), seed=3, samples=1024, threads=n) for n in (1, 2))
    content = first.to_json_dict()
    assert " ".join(content) == KEYS
    assert {**content, "seconds": 0} == {**second.to_json_dict(), "seconds": 0}
    assert (content["verdict"], content["kind"], content["upper"]) == ("unrefuted", "sampled", None)
    json.dumps(content, allow_nan=False)
    assert any("never prove" in note for note in first.notes)


def test_mixed_units_are_pointed_out_under_lemma1_only(tmp_path: Path) -> None:
    arm = chain(tmp_path, 1, 3, prismatic=True)
    assert any("rad to m" in note for note in verify(arm, 1e-3, samples=64).notes)
    assert not any("rad to m" in note for note in verify(arm, 1e-3, condition="weighted", samples=64).notes)


def test_ranges_wider_than_a_turn_are_one_turn_and_the_first_joint_is_idle(ur5: Arm) -> None:
    box = resolve_box(ur5, {"wrist_1_joint": (0.0, 7.0)})
    assert box.upper[3] - box.lower[3] == pytest.approx(2 * np.pi)
    assert box.idle.tolist() == [True] + [False] * 5
    assert box.wrap(np.array([0, 0, 0, 20.0, 0, 0]))[3] == pytest.approx(20.0 - 6 * np.pi)


@pytest.mark.parametrize(
    ("mbar", "options", "message"),
    [
        ([0.1, 0.1, 0.1], {}, "3 values given, 2 expected"),
        ([0.1, -0.1], {}, "must be positive"),
        ([0.1, float("nan")], {}, "must be positive"),
        ("abc", {}, "numbers expected"),
        (0.1, {"condition": "lemma2"}, "lemma1, weighted"),
        (0.1, {"box": {"elbow": (0, 1)}}, "not a joint of two_link.*joint_1, joint_2"),
        (0.1, {"box": {"joint_2": (1, 0)}}, "empty"),
        (0.1, {"box": {"joint_2": (0, float("nan"))}}, "not finite"),
        (0.1, {"box": {"joint_2": (-1e300, 1e300)}}, "within ±1e\\+06 expected"),
        (0.1, {"box": {"joint_2": 1.0}}, r"\(lower, upper\) expected"),
        (0.1, {"samples": 0}, "from 1 to 16777216"),
        (0.1, {"payload": (3.0, 1.0)}, "empty"),
        (0.1, {"payload": (1.0, 2.0, 3.0)}, "3 values given"),
        (0.1, {"armature": [0.1, 0.1, 0.1]}, "3 values given"),
        (0.1, {"armature": [(0.2, 0.1), 0.0]}, "lower end first"),
        (0.1, {"armature": {"elbow": 0.1}}, "not a moving joint"),
        (0.1, {"lock": {"joint_2": []}}, "no angle"),
        (0.1, {"along": 3.0}, "a reference or recorded data expected"),
        (0.1, {"along": Swing(), "tube_width": -1.0}, "zero or more"),
        (0.1, {"along": Swing(duration=float("inf"))}, "give a duration"),
    ],
)
def test_bad_input_is_one_clear_message(two_link: Arm, mbar: object, options: dict, message: str) -> None:
    with pytest.raises(ParameterError, match=message):
        verify(two_link, mbar, **options)


def test_a_slide_without_limits_asks_for_its_range(tmp_path: Path) -> None:
    path = tmp_path / "slide.urdf"
    chain(tmp_path, 1, 3, prismatic=True)
    text = (tmp_path / "chain_1_3_True.urdf").read_text().replace('lower="-0.4" upper="0.4"', 'lower="0" upper="0"')
    path.write_text(text)
    arm = load_arm(path)
    with pytest.raises(ArmError, match="--box j1=lo:hi"):
        verify(arm, 1e-3, samples=64)
    assert verify(arm, 1e-3, samples=64, box={"j1": (-0.1, 0.2)}).verdict == "unrefuted"
