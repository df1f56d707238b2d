"""What a theorem's hypotheses rest on: without a guard, or with its sign turned, something false would be provable."""

from __future__ import annotations

from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from arm_urdf import inertial, joint, link, robot, write
from certificate_cases import Question, largest_proven, proven_in_one_box, question, random_tree
from condition_cases import chain

from asmc_pin import Setpoint, load_arm, verify
from asmc_pin._typing import Array
from asmc_pin.arms import Arm, Payload
from asmc_pin.condition import lemma1_norm
from asmc_pin.condition.certificate import certify, strategy
from asmc_pin.condition.certificate.compiled.bisection_tree import cell
from asmc_pin.condition.certificate.search_and_proof import certified
from asmc_pin.condition.certificate.statement import Kind, Statement
from asmc_pin.condition.certificate.statement_forms import DATA, MARGIN, _largest, problem_of
from asmc_pin.condition.certificate.walk import Walk
from asmc_pin.condition.checker import check
from asmc_pin.condition.domain.along_motion import FollowedMotion, tube
from asmc_pin.condition.domain.arm_ranges import cases
from asmc_pin.condition.domain.joint_box import resolve_box
from asmc_pin.condition.search.samples import figures_at
from asmc_pin.errors import ArmError, NotPositiveDefinite, ParameterError
from asmc_pin.numerics.cholesky import surely_positive
from asmc_pin.references import Quintic
from asmc_pin.rigid_body.mass_matrix import mass_matrices
from asmc_pin.rigid_body.tree import Tree

KINDS: tuple[Kind, ...] = ("weighted", "bounded", "lemma1", "level")


@pytest.fixture(scope="module")
def two_link() -> Arm:
    return load_arm("two_link")


@pytest.fixture(scope="module")
def ur5() -> Arm:
    return load_arm("ur5")


# --- payloads --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("run", [verify, certify], ids=["verify", "certify"])
@pytest.mark.parametrize(
    ("light", "heavy"),
    [
        (Payload(1.0), Payload(2.0, com=(0.0, 0.0, 0.1))),
        (Payload(1.0, com=(0.0, 0.0, 0.1)), Payload(1.0, com=(0.0, 0.0, -0.1))),
        (Payload(1.0, link="link_1"), Payload(2.0, link="link_2")),
    ],
    ids=["another centre", "another centre, one mass", "another link"],
)
def test_a_payload_range_is_of_one_centre_on_one_link(two_link: Arm, run: Any, light: Payload, heavy: Payload) -> None:
    with pytest.raises(ParameterError, match="different centres or links"):
        run(two_link, 0.01, payload=(light, heavy))


def test_between_two_centres_the_condition_need_not_hold_where_it_holds_at_both(two_link: Arm) -> None:
    # The reason of the refusal: M is affine in a load that is split between two places, and not in where it is.
    ends = [two_link.replace(payload=Payload(1.0, com=(x, 0.0, 0.0))) for x in (-3.0, 3.0)]
    between = two_link.replace(payload=Payload(1.0, com=(0.0, 0.0, 0.0)))
    q = np.array([0.0, 0.5])
    mean = 0.5 * (ends[0].mass_matrix(q) + ends[1].mass_matrix(q))
    assert np.linalg.eigvalsh(between.mass_matrix(q) - mean)[0] < -1.0


def test_two_payloads_of_one_mass_are_no_range_of_it(two_link: Arm) -> None:
    with pytest.raises(ParameterError, match="a lighter and a heavier end"):
        verify(two_link, 0.01, payload=(Payload(1.0), Payload(1.0, inertia=(0.1, 0.0, 0.0, 0.1, 0.0, 0.1))))


def test_the_light_end_without_mass_has_no_centre(two_link: Arm) -> None:
    found = cases(two_link, payload=(Payload(0.0), Payload(2.0, com=(0.0, 0.0, 0.1))))
    assert [case.label for case in found] == ["payload 0 kg", "payload 2 kg"]


def test_ends_of_two_shapes_cover_the_bodies_on_the_line_between_them(two_link: Arm) -> None:
    light = Payload(1.0, inertia=(0.3, 0.0, 0.0, 0.3, 0.0, 0.01))
    heavy = Payload(2.0, inertia=(0.01, 0.0, 0.0, 0.02, 0.0, 0.02))
    report = verify(two_link, 0.05, payload=(light, heavy), samples=256)
    assert report.hypotheses.payload is not None
    assert report.hypotheses.payload.inertia_lightest == light.inertia
    for share in (0.25, 0.5, 0.75):
        inertia = tuple((1.0 - share) * a + share * b for a, b in zip(light.inertia, heavy.inertia, strict=True))
        between = two_link.replace(payload=Payload(1.0 + share, inertia=inertia))  # type: ignore[arg-type]
        assert verify(between, 0.05, samples=256).lower <= report.lower + 1e-12


# --- armature --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("armature", [-0.1, (-0.1, 0.1), (0.0, np.inf), np.nan, [(0.0, np.nan), 0.0]])
def test_no_armature_is_negative_or_without_end(two_link: Arm, armature: Any) -> None:
    for run in (verify, certify):
        with pytest.raises(ParameterError, match="armature"):
            run(two_link, 0.01, armature=armature)  # type: ignore[operator]


def test_each_statement_is_made_at_the_end_of_the_armatures_range_that_covers_it(two_link: Arm) -> None:
    low, high = np.array([0.02, 0.01]), np.array([0.05, 0.03])
    ranges = list(zip(low.tolist(), high.tolist(), strict=True))
    weighted = certify(two_link, 0.01, condition="weighted", armature=ranges, budget=10.0)
    scale, *level = [proof.statement for proof in weighted.proofs]
    assert (scale.kind, scale.level, scale.armature.tolist(), scale.slack.tolist()) == ("weighted", 1.0, [*low], [0, 0])
    assert {item.kind for item in level} == {"weighted", "bounded"}
    for item in level:
        assert np.all(item.armature == low)
        assert np.all(item.armature + item.slack == (high if item.kind == "bounded" else low))
    lemma1 = certify(two_link, 0.01, armature=ranges, budget=10.0)
    scale, *level = [proof.statement for proof in lemma1.proofs]
    assert (scale.kind, scale.armature.tolist(), scale.slack.tolist()) == ("lemma1", [*low], [0, 0])
    corners = {tuple(item.armature.tolist()) for item in level if item.kind == "level"}
    assert corners == {(a, b) for a in (low[0], high[0]) for b in (low[1], high[1])}


@pytest.mark.parametrize("kind", ["bounded", "level"])
def test_a_statement_with_slack_holds_with_all_of_it(kind: Kind) -> None:
    # At single configurations a proof is as strong as the truth, so one that forgot the slack would exceed it.
    met = 0
    for seed in range(300, 340):
        asked = question(seed, kind, largest=4, point=True)
        if asked is None:
            continue
        slack = np.random.default_rng(seed).uniform(0.5, 1.0, asked.tree.nv) * asked.mbar
        true = _largest_true(asked, kind, slack)
        if true <= 1e-3:
            continue
        low, high = 0.0, min(1.5 * true, 0.999)
        for _ in range(20):
            x = 0.5 * (low + high)
            low, high = (x, high) if proven_in_one_box(_Slackened(asked, slack), x) else (low, x)
        assert low <= true
        met += low > 0.5 * true
    assert met > 5


class _Slackened:
    """A question whose statements also cover more armature."""

    def __init__(self, asked: Question, slack: Array) -> None:
        self._asked, self._slack = asked, slack

    def __getattr__(self, name: str) -> Any:
        return getattr(self._asked, name)

    def statement(self, x: float) -> Statement:
        return replace(self._asked.statement(x), slack=self._slack)


def _largest_true(asked: Question, kind: Kind, slack: Array) -> float:
    """The largest 1 − γ that is true at the point with every corner of the slack."""
    (mass,) = mass_matrices(asked.tree, asked.lower[None, :])
    corners = np.array(np.meshgrid(*[[0.0, 1.0]] * asked.tree.nv)).reshape(asked.tree.nv, -1).T * slack
    masses = mass + corners[:, :, None] * np.eye(asked.tree.nv)
    if kind == "bounded":
        root = 1.0 / np.sqrt(asked.mbar)
        return float(1.0 / np.linalg.eigvalsh(masses * root[:, None] * root)[:, -1].max())
    return float(1.0 - lemma1_norm(masses, asked.mbar).max())


def test_along_a_motion_the_norm_is_the_largest_of_all_ends_of_the_armature(two_link: Arm) -> None:
    time = np.linspace(0.0, 1.0, 41)
    q = np.stack((0.0 * time, 3.0 * time), axis=-1)

    @dataclass(frozen=True)
    class Swing:
        duration: float = 1.0

        def evaluate(self, t: Array) -> Setpoint:
            at = np.stack((0.0 * t, 3.0 * t), axis=-1)
            return Setpoint(at, at, at)

    report = verify(two_link, 0.23, along=Swing(), period=0.025, armature=[(0.0, 0.4), (0.1, 0.2)])
    corners = [np.diag([a, b]) for a in (0.0, 0.4) for b in (0.1, 0.2)]
    norms = [lemma1_norm(two_link.mass_matrix(q) + extra, np.full(2, 0.23)) for extra in corners]
    assert report.norms == pytest.approx(np.max(norms, axis=0), rel=1e-12)
    # Not one and the same end everywhere, so that none of them alone would do.
    assert len(set(np.argmax(norms, axis=0))) > 1


# --- boxes and tubes -------------------------------------------------------------------------------------------------


def test_a_turning_joint_is_cut_to_one_turn_about_the_middle_of_its_range(ur5: Arm) -> None:
    box = resolve_box(ur5, {"wrist_1_joint": (0.0, 7.0), "wrist_2_joint": (-3.0, 3.0), "elbow_joint": (0.5, 0.5)})
    assert (box.lower[3], box.upper[3]) == pytest.approx((3.5 - np.pi, 3.5 + np.pi))
    assert (box.lower[4], box.upper[4]) == (-3.0, 3.0)
    assert (box.lower[2], box.upper[2]) == (0.5, 0.5)
    assert box.periodic.tolist() == [True, True, False, True, False, True]


def test_a_slide_is_never_cut_to_a_turn(tmp_path: Path) -> None:
    arm = chain(tmp_path, 1, 3, prismatic=True)
    box = resolve_box(arm, {"j1": (-5.0, 20.0)})
    assert (box.lower[1], box.upper[1], bool(box.periodic[1])) == (-5.0, 20.0, False)
    found = certify(arm, 1e-4, condition="weighted", box={"j1": (-5.0, 20.0)}, gap=0.5, budget=0.5, levels=False)
    assert found.hypotheses.box["j1"] == (-5.0, 20.0)
    assert found.cases[0].domain.box.upper[1] == 20.0


@pytest.mark.parametrize("slices", [1, 3, 7, 20, 500])
def test_the_slices_of_a_tube_hold_each_configuration_and_what_lies_between_two(slices: int) -> None:
    rng = np.random.default_rng(slices)
    motion = FollowedMotion(np.linspace(0.0, 1.0, 21), np.cumsum(rng.normal(size=(21, 2)), axis=0), "a walk")
    parts = tube(motion, [0.0, 0.25], slices)
    assert (parts[0].start, parts[-1].end) == (0.0, 1.0)
    assert len(parts) == min(slices, 20)
    for before, after in pairwise(parts):
        assert before.end == after.start
    reach = np.array([0.0, 0.25])
    for share in (0.0, 0.25, 0.5, 1.0):
        for k in range(20):
            q, t = (x[k] + share * (x[k + 1] - x[k]) for x in (motion.q, motion.times))
            there = [part for part in parts if part.start <= t <= part.end]
            assert there
            assert any(np.all((part.lower <= q - reach) & (q + reach <= part.upper)) for part in there)
    still = tube(FollowedMotion(np.zeros(1), np.ones((1, 2)), "a point"), 0.5)
    assert [(part.lower.tolist(), part.upper.tolist()) for part in still] == [([0.5, 0.5], [1.5, 1.5])]


def test_every_slice_is_proven_for_every_arm_of_the_ranges(two_link: Arm) -> None:
    @dataclass(frozen=True)
    class Swing:
        duration: float = 1.0

        def evaluate(self, t: Array) -> Setpoint:
            q = np.stack((0.0 * t, t), axis=-1)
            return Setpoint(q, q, q)

    found = certify(
        two_link, 0.01, along=Swing(), tube_width=0.1, slices=3, payload=(0.0, 1.0), budget=20.0, levels=False
    )
    assert len(found.cases) == 6
    starts = sorted(float(case.domain.box.lower[1]) for case in found.cases)
    assert starts == pytest.approx([-0.1, -0.1, 1 / 3 - 0.1, 1 / 3 - 0.1, 2 / 3 - 0.1, 2 / 3 - 0.1], abs=2e-3)
    assert sorted(proof.statement.case for proof in found.proofs) == list(range(6))


def test_slices_in_which_the_motion_rests_are_one_statement(two_link: Arm, tmp_path: Path) -> None:
    rest = Quintic(start=[0.0, 0.0], targets=[[0.0, 0.4]], times=[0.4], move=0.2)
    options: dict[str, Any] = {"along": rest, "tube_width": 0.1, "slices": 10, "duration": 1.0}
    found = certify(two_link, 0.01, budget=20.0, levels=False, **options)
    assert 3 <= len(found.cases) == found.hypotheses.parts < 10
    assert certified(verify(two_link, 0.01, samples=64, **options), found).verdict == "holds"
    assert check(found.save(tmp_path / "rest.cert")).valid
    lock: dict[str, Any] = {"lock": {"joint_2": [0.5, 0.5]}}
    assert len(certify(two_link, 0.01, budget=5.0, levels=False, **lock).cases) == 1


@pytest.mark.parametrize(
    "ends", ['<limit effort="1" velocity="1"/>', '<limit lower="0" upper="0" effort="1" velocity="1"/>']
)
def test_a_slide_without_limits_has_no_box_to_guess(tmp_path: Path, ends: str) -> None:
    rail = joint("rail", "base", "body", "prismatic", extra=ends)
    arm = load_arm(write(tmp_path, robot(link("base"), link("body", inertial()), rail)))
    for run in (verify, certify):
        with pytest.raises(ArmError, match="--box rail=lo:hi"):
            run(arm, 0.1)  # type: ignore[operator]
    assert certify(arm, 0.1, condition="weighted", box={"rail": (0.0, 2.0)}, budget=5.0).verdict == "holds"


def test_the_cells_of_a_box_cover_it_in_exact_fractions() -> None:
    rng = np.random.default_rng(0)
    tree = random_tree(rng, 3)
    for _ in range(50):
        lower = rng.uniform(-4.0, 3.0, 3) * 10.0 ** rng.uniform(-6.0, 1.0, 3)
        upper = lower + 10.0 ** rng.uniform(-8.0, 0.8, 3)
        problem = problem_of(
            tree, lower, upper, np.ones(3), Statement("weighted", 1.0, 1.0, 0, np.zeros(3), np.zeros(3))
        )
        level = rng.integers(0, 30, 3)
        index = np.array([rng.integers(0, 2**k) for k in level])
        c, r = np.empty(3), np.empty(3)
        cell(problem, level, index, c, r)
        for j in range(3):
            lo, hi = Fraction(float(lower[j])), Fraction(float(upper[j]))
            part = (hi - lo) / 2 ** int(level[j])
            assert Fraction(float(c[j])) - Fraction(float(r[j])) <= lo + part * int(index[j])
            assert Fraction(float(c[j])) + Fraction(float(r[j])) >= lo + part * (int(index[j]) + 1)


# --- the first two joints --------------------------------------------------------------------------------------------


def _two_roots(folder: Path) -> Arm:
    """Two arms on one base; M is block diagonal."""
    return load_arm(
        write(
            folder,
            robot(
                link("base"),
                *(link(name, inertial(mass)) for name, mass in (("a", 2.0), ("b", 1.0), ("c", 3.0), ("d", 1.5))),
                joint("a1", "base", "a", axis="0 1 0"),
                joint("a2", "a", "b", axis="1 0 0"),
                joint("c1", "base", "c", axis="1 0 0", xyz="1 0 0"),
                joint("c2", "c", "d", axis="0 1 0"),
            ),
        )
    )


def test_only_joints_on_the_base_are_idle_and_all_of_them_are(tmp_path: Path, ur5: Arm) -> None:
    assert resolve_box(ur5).idle.tolist() == [True] + [False] * 5
    arm = _two_roots(tmp_path)
    idle = resolve_box(arm).idle
    assert idle.tolist() == [parent < 0 for parent in arm.tree.parent]
    assert sum(idle) == 2
    rng = np.random.default_rng(0)
    q = rng.uniform(-2.0, 2.0, (20, 4))
    turned = q + np.where(idle, rng.uniform(-2.0, 2.0, (20, 4)), 0.0)
    assert arm.mass_matrix(turned) == pytest.approx(arm.mass_matrix(q), abs=1e-12)
    for i in np.flatnonzero(~idle):
        moved = q.copy()
        moved[:, i] += 1.0
        assert np.abs(arm.mass_matrix(moved) - arm.mass_matrix(q)).max() > 1e-3


@pytest.mark.parametrize("condition", ["lemma1", "weighted"])
def test_two_arms_on_one_base_are_proven_as_far_as_each_alone(tmp_path: Path, condition: Any) -> None:
    arm = _two_roots(tmp_path)
    q = np.random.default_rng(1).uniform(-2.0, 2.0, (4000, 4))
    mbar = np.full(4, 0.8 * np.linalg.eigvalsh(arm.mass_matrix(q)).min())
    found = certify(arm, mbar, condition=condition, gap=0.02, budget=20.0)
    assert found.gap <= 0.02
    least = np.linalg.eigvalsh(arm.mass_matrix(q))[:, 0].min()
    assert found.scale_proven * mbar[0] < 2.0 * least


def test_the_second_joint_is_followed_exactly_only_where_it_turns_on_the_first() -> None:
    def exact(parent: list[int], slides: list[bool]) -> bool:
        tree = random_tree(np.random.default_rng(0), len(parent))
        tree = replace(tree, parent=np.array(parent), prismatic=np.array(slides))
        none, one = np.zeros(len(parent)), np.ones(len(parent))
        statement = Statement("weighted", 1.0, 1.0, 0, none, none)
        return problem_of(tree, -one, one, one, statement).exact

    assert exact([-1, 0], [False, False])
    assert exact([-1, 0, 1], [True, False, True])
    assert not exact([-1], [False])
    assert not exact([-1, 0], [False, True])
    assert not exact([-1, -1], [False, False])
    assert not exact([-1, -1, 0], [False, False, False])


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("shape", ["second root", "second slides"])
def test_where_the_second_joint_is_not_followed_exactly_proofs_stay_below_the_truth(kind: Kind, shape: str) -> None:
    met = 0
    for seed in range(120):
        asked = question(seed, kind, largest=3)
        if asked is None or asked.tree.nv < 2:
            continue
        second = asked.tree.parent[1] < 0 if shape == "second root" else asked.tree.prismatic[1]
        if second:
            met += 1
            assert largest_proven(asked, proven_in_one_box, steps=12) <= asked.worst * (1.0 + 1e-9)
    assert met > 1


# --- M̄, levels, M ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("mbar", [0.0, -0.0, -1.0, np.inf, np.nan, [0.1, 0.0], [0.1, np.inf]])
def test_every_mbar_is_positive_and_finite(two_link: Arm, mbar: Any) -> None:
    for run in (verify, certify):
        with pytest.raises(ParameterError, match="must be positive and finite"):
            run(two_link, mbar)  # type: ignore[operator]


@pytest.mark.parametrize("level", [0.0, -0.5, 1.0 + 1e-12, np.inf, np.nan])
def test_a_level_is_above_0_and_at_most_1(two_link: Arm, level: float) -> None:
    with pytest.raises(ParameterError, match="level"):
        certify(two_link, 0.01, level=level)


def test_an_inertia_that_is_not_positive_definite_is_no_arm_to_verify(two_link: Arm) -> None:
    tree: Tree = two_link.tree
    bad = replace(two_link, tree=replace(tree, inertia=-tree.inertia, mass=-tree.mass))
    for run in (verify, certify):
        with pytest.raises(NotPositiveDefinite):
            run(bad, 0.01)  # type: ignore[operator]
    with pytest.raises(NotPositiveDefinite):
        figures_at(0, bad.tree, np.zeros((1, 2)), np.full(2, 0.01))


@pytest.mark.parametrize("kind", ["weighted", "lemma1"])
def test_neither_condition_is_ever_proven_of_a_matrix_that_is_not_positive_definite(kind: Kind) -> None:
    # M ≻ f/2 M̄, and N M + M N ≻ f I by Lyapunov, each say that M ≻ 0; so no f > 0 may be proven.
    rng = np.random.default_rng(0)
    for joints in (1, 2, 3, 4) * 8:
        tree = random_tree(rng, joints)
        point = rng.uniform(-1.0, 1.0, joints)
        (mass,) = mass_matrices(replace(tree, armature=np.zeros(joints)), point[None, :])
        # What one joint lacks makes M indefinite by a hair, or by much.
        i = int(rng.integers(joints))
        lacks = np.zeros(joints)
        lacks[i] = -(1.0 + 10.0 ** rng.uniform(-4.0, 1.0)) / np.linalg.inv(mass)[i, i]
        asked = Question(replace(tree, armature=lacks), point, point, np.diag(mass).copy(), kind, 1.0)
        assert np.linalg.eigvalsh(mass + np.diag(lacks))[0] < 0.0
        assert not any(proven_in_one_box(asked, x) for x in (1e-12, 1e-6, 1e-3, 1.0))


# --- margins ---------------------------------------------------------------------------------------------------------


def _own_form(kind: Kind, f: float, gamma: float, armature: float, mbar: float) -> Array:
    """The joint's own form of a statement, without any margin."""
    if kind == "weighted":
        return np.array([[armature - f / (1.0 + gamma) * mbar]])
    if kind == "bounded":
        return np.array([[f / (1.0 - gamma) * mbar - armature]])
    if kind == "lemma1":
        return np.array([[2.0 * armature - f * mbar]])
    s = np.sqrt(1.0 - gamma**2)
    return np.array([[2.0 * armature - f * mbar, s * armature], [s * armature, f * mbar]])


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("share", [1e9, 1e-9], ids=["large M̄", "small M̄"])
def test_what_is_proven_is_stronger_than_what_is_claimed_by_the_margins(kind: Kind, share: float) -> None:
    # With a large M̄ all that is taken off is the margin of f, with a small one the share for the data's last digits.
    rng = np.random.default_rng(0)
    for _ in range(20):
        tree = random_tree(rng, 4)
        lower, upper = -np.ones(4), np.ones(4)
        largest = _largest(tree, lower, upper)
        mbar = share * largest
        scale, gamma = rng.uniform(0.1, 1.5), 1.0 if kind in ("weighted", "lemma1") else rng.uniform(0.1, 0.9)
        none = np.zeros(4)
        problem = problem_of(tree, lower, upper, mbar, Statement(kind, scale, gamma, 0, none, none))
        for i in range(4):
            taken = _own_form(kind, scale, gamma, 0.0, mbar[i]) - problem.joint[i]
            assert taken == pytest.approx(taken.T, abs=1e-12 * np.abs(taken).max())
            least = np.linalg.eigvalsh(taken)[0]
            if share > 1.0:
                assert least >= 0.25 * MARGIN * scale * mbar[i]
            else:
                # The second velocity of a level enters the inertia with a factor s.
                assert least >= DATA * largest[i] * np.sqrt(1.0 - gamma**2 if kind == "level" else 1.0) * (1 - 1e-9)


def test_the_bound_of_the_inertia_that_the_data_margin_is_a_share_of_is_one() -> None:
    rng = np.random.default_rng(1)
    for _ in range(60):
        tree = random_tree(rng, int(rng.integers(1, 6)))
        centre, half = rng.uniform(-2.0, 2.0, tree.nv), rng.uniform(0.0, 3.0, tree.nv)
        q = rng.uniform(centre - half, centre + half, (200, tree.nv))
        bare = replace(tree, armature=np.zeros(tree.nv))
        diagonal = np.diagonal(mass_matrices(bare, q), axis1=1, axis2=2).max(axis=0)
        assert np.all(_largest(tree, centre - half, centre + half) >= diagonal * (1.0 - 1e-12))


def test_a_scale_that_is_refuted_breaks_the_condition_there_and_not_only_nearly(ur5: Arm) -> None:
    for name in ("two_link", "double_pendulum"):
        arm = load_arm(name)
        found = certify(arm, 0.01, gap=0.1, budget=5.0, levels=False)
        mass = arm.mass_matrix(found.refuted_q)
        assert lemma1_norm(mass, found.scale_refuted * found.mbar) > 1.0


def _exactly_positive(S: Array, slack: Array) -> bool:
    P = [[Fraction(float(x)) for x in row] for row in S]
    for k in range(len(P)):
        P[k][k] -= Fraction(float(slack[k]))
    for k in range(len(P)):
        if P[k][k] <= 0:
            return False
        for i in range(k + 1, len(P)):
            factor = P[i][k] / P[k][k]
            P[i] = [a - factor * b for a, b in zip(P[i], P[k], strict=True)]
    return True


def test_what_cholesky_calls_positive_is_so_with_its_slack_taken_off() -> None:
    rng = np.random.default_rng(7)
    yes = no = 0
    for _ in range(300):
        m = int(rng.integers(1, 13))
        basis = np.linalg.qr(rng.normal(size=(m, m)))[0]
        S = (basis * 10.0 ** rng.uniform(-1.0, 1.0, m)) @ basis.T
        slack = rng.uniform(0.0, 1.0, m)
        S = (
            S
            + np.diag(slack)
            - (np.linalg.eigvalsh(S)[0] + rng.choice([-1, 1]) * 10.0 ** rng.uniform(-9, -2)) * np.eye(m)
        )
        S = np.tril(S) + np.tril(S, -1).T
        sure = surely_positive(S, slack, np.empty((m, m)))
        if sure:
            assert _exactly_positive(S, slack)
        yes, no = yes + sure, no + (not sure)
    assert yes > 50
    assert no > 50


def test_a_walk_that_was_stopped_proves_nothing(two_link: Arm, monkeypatch: pytest.MonkeyPatch) -> None:
    whole = strategy.prove
    assert certify(two_link, 0.01, budget=5.0, levels=False).scale_proven >= 1.0

    def stopped(problem: Any, **options: Any) -> Walk:
        return replace(whole(problem, **options), status="stopped")

    monkeypatch.setattr(strategy, "prove", stopped)
    found = certify(two_link, 0.01, budget=5.0)
    assert found.proofs == ()
    assert (found.scale_proven, found.upper, found.verdict) == (0.0, None, "undecided")
