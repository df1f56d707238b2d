"""The condition in ball arithmetic: so for all numbers in the balls, and where a proof is wrong, found without it."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from arm_urdf import inertial, joint, link, robot, write
from check_cases import KINDS, arm, case, condition_of, header, hexed, parsed_case, parsed_statement, statement, told
from flint import arb, arb_mat, ctx

from asmc_pin import load_arm
from asmc_pin._typing import Array
from asmc_pin.arms import arm_names
from asmc_pin.condition import lemma1_norm, weighted_norm
from asmc_pin.condition.checker import spot_checks
from asmc_pin.condition.checker.balls.ball_geometry import normalised
from asmc_pin.condition.checker.balls.balls import (
    BallArm,
    Verdict,
    downward,
    holds,
    no_multiple,
    norm_bound,
    positive,
)
from asmc_pin.condition.checker.boxes import box_bounds, statements
from asmc_pin.condition.checker.boxes.quadratic_form import form_of, least_eigenvalues
from asmc_pin.condition.checker.reading.certificate_schema import Contents
from asmc_pin.condition.checker.reading.header_parts import Load
from asmc_pin.condition.checker.reading.link_chain import Chain, chain_of
from asmc_pin.condition.checker.reading.urdf_text import description


@pytest.fixture(autouse=True)
def _bits() -> Any:
    with ctx.workprec(128):
        yield


def _matrix(M: Array, radius: float = 0.0) -> arb_mat:
    return arb_mat([[arb(float(x), radius) for x in row] for row in M])


def _random_mass(rng: np.random.Generator, n: int) -> Array:
    L = rng.normal(size=(n, n)) + 0.3 * np.eye(n)
    return np.asarray(L @ L.T + 0.05 * np.eye(n))


# The inertia matrix -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", arm_names())
def test_the_inertia_matrix_in_balls_is_the_loaders(name: str) -> None:
    load = {"mass": 1.0, "com": (0.01, 0.02, 0.03), "inertia": (0.01, 0.001, 0.002, 0.02, 0.003, 0.015)}
    for loaded in (load_arm(name), load_arm(name, payload=load)):
        payload = loaded.payload
        inside = None
        if payload is not None:
            inside = Load.model_construct(**{key: getattr(payload, key) for key in ("mass", "com", "inertia", "link")})
        text = description(loaded.urdf_text)
        balls = BallArm(text, loaded.joint_names, loaded.locked, inside)
        chain = chain_of(text, loaded.joint_names, loaded.locked, inside)
        q = np.random.default_rng(0).uniform(-3.0, 3.0, loaded.nv)
        M = loaded.mass_matrix(q)
        B = balls.mass_matrix([arb(x) for x in q], [arb(a) for a in loaded.armature])
        off = np.array([[float(abs(B[i, j] - M[i, j]).upper()) for j in range(loaded.nv)] for i in range(loaded.nv)])
        assert off.max() < 1e-13 * np.abs(M).max()
        assert max(float(B[i, i].rad()) for i in range(loaded.nv)) < 1e-30 * np.abs(M).max()
        assert chain.mass_matrix(q, loaded.armature) == pytest.approx(M, rel=0.0, abs=1e-13 * np.abs(M).max())


def test_locked_joints_and_slides_are_where_the_loader_has_them(tmp_path: Any) -> None:
    from condition_cases import chain as chain_arm

    sliding = chain_arm(tmp_path, 4, 4, prismatic=True)
    for lock in ({"j2": 0.13}, {"j1": -0.7, "j3": 1.1}, {"j0": 0.4}):
        loaded = sliding.replace(lock=lock)
        text = description(loaded.urdf_text)
        balls = BallArm(text, loaded.joint_names, loaded.locked, None)
        floats = chain_of(text, loaded.joint_names, loaded.locked, None)
        for q in np.random.default_rng(1).uniform(-1.0, 1.0, (3, loaded.nv)):
            B = balls.mass_matrix([arb(x) for x in q], [arb(0)] * loaded.nv)
            M = loaded.mass_matrix(q) - np.diag(loaded.armature)
            ours = np.array([[float(B[i, j].mid()) for j in range(loaded.nv)] for i in range(loaded.nv)])
            assert ours == pytest.approx(M, rel=0.0, abs=1e-13 * np.abs(M).max())
            assert floats.arm_mass(q) == pytest.approx(M, rel=0.0, abs=1e-13 * np.abs(M).max())


def test_an_axis_of_any_length_is_the_direction_that_it_points_in() -> None:
    for axis, unit in (
        (("1", "2", "2"), (1, 2, 2)),
        (("0", "0", "-30"), (0, 0, -3)),
        (("6e-3", "0", "8e-3"), (1.8, 0, 2.4)),
    ):
        found = normalised(axis)
        assert all(abs(3 * found[k, 0] - arb(unit[k])) < 1e-14 for k in range(3))


def test_of_a_tree_with_welded_links_and_branches_both_arithmetics_have_the_loaders_matrix(tmp_path: Path) -> None:
    tree = robot(
        link("base"),
        *(
            link(name, inertial(mass, rpy="0.1 0.2 0.3"))
            for name, mass in zip("abcdef", (3.0, 0.5, 2.0, 1.0, 0.7, 0.9), strict=True)
        ),
        joint("j0", "base", "a", axis="0 0 2"),
        # A weld that comes first among a link's joints, and one with a moving joint behind it.
        joint("w0", "a", "b", "fixed", xyz="0 0.2 0", rpy="0.3 0 1"),
        joint("j1", "a", "c", axis="1 2 2", rpy="0 0.4 0.1"),
        joint("w1", "c", "d", "fixed", xyz="0.1 0 0.1", rpy="0 1 0"),
        joint("j2", "d", "e", "prismatic", axis="0 -3 4"),
        joint("j3", "a", "f", axis="0 5 0", xyz="0 0 0.4"),
    )
    loaded = load_arm(write(tmp_path, tree))
    assert loaded.nv == 4
    read = description(loaded.urdf_text)
    q, free = np.array([0.4, -0.8, 0.3, 1.2]), np.broadcast_to(loaded.armature, 4)
    M = loaded.mass_matrix(q)
    B = BallArm(read, loaded.joint_names, loaded.locked, None).mass_matrix([arb(x) for x in q], [arb(a) for a in free])
    ours = np.array([[float(B[i, j].mid()) for j in range(4)] for i in range(4)])
    assert ours == pytest.approx(M, rel=0.0, abs=1e-12)
    assert chain_of(read, loaded.joint_names, loaded.locked, None).mass_matrix(q, free) == pytest.approx(M, abs=1e-12)


@pytest.mark.parametrize("prismatic", [False, True])
def test_a_ball_of_configurations_has_the_matrix_of_each_of_them_inside(prismatic: bool) -> None:
    rng = np.random.default_rng(2)
    for seed in range(4):
        chain, balls = arm(seed, 4, prismatic)
        centre, radius = rng.uniform(-2.0, 2.0, 4), 10.0 ** rng.uniform(-4.0, -0.5)
        low, high = np.zeros(4), rng.uniform(0.0, 0.5, 4)
        armature = [arb(0.5 * float(h), 0.5 * float(h) + 1e-12) for h in high]
        wide = balls.mass_matrix([arb(float(x), radius) for x in centre], armature)
        for share in (*rng.uniform(-1.0, 1.0, (10, 4)), np.ones(4), -np.ones(4)):
            a = low + rng.random(4) * (high - low)
            one = balls.mass_matrix([arb(float(x)) for x in centre + share * radius * 0.999999], [arb(x) for x in a])
            assert all(wide[i, j].contains(one[i, j]) for i in range(4) for j in range(4))
        # And not without need: by no more than a few times what the angles do.
        spread = max(float(wide[i, j].rad()) for i in range(4) for j in range(4))
        assert spread < 300.0 * (radius + high.max()) * np.abs(chain.mass_matrix(centre, high)).max()


# The statements -----------------------------------------------------------------------------------------------------


def _norm(kind: str, M: Array, mbar: Array, f: float) -> float:
    """What the statement bounds, less its bound."""
    root = np.sqrt(mbar)
    values = f * np.linalg.eigvalsh(root[:, None] * np.linalg.inv(M) * root)
    if kind == "weighted":
        return float(values[-1] - 1.0)
    if kind == "bounded":
        return float(1.0 - values[0])
    return float(np.linalg.norm(np.eye(len(M)) - f * np.linalg.inv(M) * mbar, 2))


@pytest.mark.parametrize("kind", KINDS)
def test_a_statement_in_balls_is_true_below_its_level_and_false_above(kind: str) -> None:
    rng = np.random.default_rng(3)
    asked = 0
    for _ in range(60):
        n = int(rng.integers(1, 6))
        M = _random_mass(rng, n)
        mbar = np.diag(M) * rng.uniform(0.2, 1.2, n)
        if kind in ("lemma1", "level"):
            mbar = np.full(n, np.linalg.eigvalsh(M)[0]) * rng.uniform(0.9, 1.1, n)
        f = rng.uniform(0.5, 1.0)
        if kind == "weighted":
            f = rng.uniform(1.05, 1.95) / (1.0 + _norm(kind, M, mbar, 1.0))
        norm = _norm(kind, M, mbar, f)
        if kind == "lemma1":
            # The scale at which the norm is one, by bisection in floats.
            low, high = 0.0, 100.0
            for _ in range(80):
                f = 0.5 * (low + high)
                low, high = (f, high) if _norm(kind, M, mbar, f) < 1.0 else (low, f)
            for share, verdict in ((1.0 - 1e-9, "true"), (1.0 + 1e-9, "false")):
                said = parsed_statement(n, kind, scale=low * share)
                assert holds(said, _matrix(M), mbar.tolist()) == verdict
            asked += 1
            continue
        if not 1e-3 < norm < 0.999:
            continue
        asked += 1
        for level, verdict in ((norm + 1e-9, "true"), (norm - 1e-9, "false")):
            said = parsed_statement(n, kind, scale=f, level=level)
            assert holds(said, _matrix(M), mbar.tolist()) == verdict
    assert asked > 10


@pytest.mark.parametrize("kind", KINDS)
def test_at_the_edge_of_a_statement_balls_never_say_both(kind: str) -> None:
    rng = np.random.default_rng(4)
    seen = set()
    for _ in range(150):
        n = int(rng.integers(1, 4))
        M = _random_mass(rng, n)
        mbar = np.full(n, np.linalg.eigvalsh(M)[0]) * rng.uniform(0.9, 1.1, n)
        level = 1.0 if kind in ("weighted", "lemma1") else 0.9
        said = parsed_statement(n, kind, scale=rng.uniform(0.02, 2.5), level=level)
        radius = 10.0 ** rng.uniform(-6.0, -0.5) * float(np.linalg.eigvalsh(M)[0]) / n
        wide = holds(said, _matrix(M, radius), mbar.tolist())
        inside = set()
        for _ in range(4):
            E = rng.uniform(-1.0, 1.0, (n, n))
            inside.add(holds(said, _matrix(M + radius * 0.999 * (E + E.T) / 2.0), mbar.tolist()))
        seen.add(wide)
        # All that a ball says is so of every matrix in it.
        assert wide == "open" or inside == {wide}
    assert seen == {"true", "false", "open"}


def test_what_the_balls_cannot_tell_is_open() -> None:
    said = parsed_statement(2, "weighted")
    assert holds(said, _matrix(np.eye(2), 2.0), [1.0, 1.0]) == "open"
    # Exactly at the edge, M̄ = 2 M: no strict inequality.
    assert holds(said, _matrix(2.0 * np.eye(2)), [4.0, 4.0]) == "false"
    assert holds(said, _matrix(np.zeros((2, 2))), [1.0, 1.0]) == "open"


@pytest.mark.parametrize(
    ("rows", "verdict"),
    [
        ([[1]], "true"),
        ([[0]], "false"),
        ([[-1]], "false"),
        ([[2, 1], [1, 2]], "true"),
        ([[1, 1], [1, 1]], "false"),
        ([[1, 2], [2, 1]], "false"),
        ([[0, 1], [1, 5]], "false"),
        ([[4, 2, 2], [2, 2, 1], [2, 1, 1]], "false"),
        ([[4, 2, 2], [2, 2, 1], [2, 1, 2]], "true"),
        ([[1, 0, 0], [0, 1, 0], [0, 0, -1]], "false"),
    ],
)
def test_positive_is_decided_exactly_also_of_a_singular_matrix(rows: list[list[int]], verdict: Verdict) -> None:
    assert positive(len(rows), lambda i, j: arb(rows[i][j])) == verdict
    shaken = arb(0, 1e-20)
    assert positive(len(rows), lambda i, j: arb(rows[i][j]) + shaken) in (verdict, "open")
    wide = positive(len(rows), lambda i, j: arb(rows[i][j], 10.0))
    assert wide == "open"


def test_positive_agrees_with_eigenvalues_away_from_zero() -> None:
    rng = np.random.default_rng(5)
    seen = []
    for _ in range(100):
        n = int(rng.integers(1, 6))
        A = rng.normal(size=(n, n))
        A = A + A.T + rng.uniform(0.0, 6.0) * np.eye(n)
        verdict = positive(n, lambda i, j, A=A: arb(float(A[i, j])))  # type: ignore[misc]
        assert verdict == ("true" if np.linalg.eigvalsh(A)[0] > 0.0 else "false")
        seen.append(verdict)
    assert len(set(seen)) == 2


# Bounds of the norm -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("condition", ["weighted", "lemma1"])
def test_a_bound_of_the_norm_is_below_it_in_any_direction_and_close_in_a_good_one(condition: str) -> None:
    rng = np.random.default_rng(6)
    norm = {"lemma1": lemma1_norm, "weighted": weighted_norm}[condition]
    for _ in range(30):
        n = int(rng.integers(1, 6))
        M = _random_mass(rng, n)
        mbar, f = np.diag(M) * rng.uniform(0.3, 1.5, n), rng.uniform(0.3, 2.0)
        true = float(norm(M[None], f * mbar)[0])
        for _ in range(5):
            bound = norm_bound(condition, f, _matrix(M), mbar.tolist(), rng.normal(size=n).tolist())
            assert bound is not None
            assert float(bound.lower()) <= true * (1.0 + 1e-12)
        best = _best(condition, M, f * mbar)
        bound = norm_bound(condition, f, _matrix(M), mbar.tolist(), best.tolist())
        assert bound is not None
        assert float(bound.mid()) == pytest.approx(true, rel=1e-9)


def _best(condition: str, M: Array, mbar: Array) -> Array:
    if condition == "lemma1":
        return np.asarray(np.linalg.svd(np.eye(len(M)) - np.linalg.inv(M) * mbar)[2][0])
    root = np.sqrt(mbar)
    values, vectors = np.linalg.eigh(np.eye(len(M)) - root[:, None] * np.linalg.inv(M) * root)
    return np.asarray(vectors[:, np.argmax(np.abs(values))])


def test_a_bound_of_the_norm_does_not_depend_on_the_length_of_the_direction() -> None:
    M = _random_mass(np.random.default_rng(7), 3)
    for condition in ("weighted", "lemma1"):
        one, many = (norm_bound(condition, 1.0, _matrix(M), [1.0, 0.5, 2.0], [s, -s, 2.0 * s]) for s in (1.0, 7.0))
        assert one is not None
        assert many is not None
        assert float(one.mid()) == pytest.approx(float(many.mid()), rel=1e-15)


@pytest.mark.parametrize("condition", ["weighted", "lemma1"])
def test_no_direction_or_no_inverse_says_nothing_of_the_norm(condition: str) -> None:
    assert norm_bound(condition, 1.0, _matrix(np.eye(2)), [1.0, 1.0], [0.0, 0.0]) is None
    assert norm_bound(condition, 1.0, _matrix(np.zeros((2, 2))), [1.0, 1.0], [1.0, 0.0]) is None
    assert not no_multiple(_matrix(np.eye(2)), [1.0, 1.0], [0.0, 0.0])
    assert not no_multiple(_matrix(np.zeros((2, 2))), [1.0, 1.0], [1.0, 0.0])


def test_no_multiple_is_said_only_where_every_scale_fails() -> None:
    rng = np.random.default_rng(8)
    seen = set()
    for _ in range(80):
        n = int(rng.integers(2, 5))
        M, mbar = _random_mass(rng, n), 10.0 ** rng.uniform(-2.0, 1.0, n)
        A = np.linalg.inv(M) * mbar
        values, vectors = np.linalg.eigh(A + A.T)
        said = no_multiple(_matrix(M), mbar.tolist(), vectors[:, 0].tolist())
        assert said == (values[0] < 0.0)
        seen.add(said)
        if said:
            assert min(np.linalg.norm(np.eye(n) - f * A, 2) for f in 10.0 ** np.linspace(-4.0, 2.0, 60)) >= 1.0
    assert seen == {True, False}


def test_no_multiple_takes_the_edge_in_and_not_what_is_open() -> None:
    # u M⁻¹M̄ u = 0 exactly: the norm is then √(1 + …) ≥ 1 for every scale.
    M, mbar = np.array([[2.0, 1.0], [1.0, 1.0]]), [1.0, 1.0]
    assert not no_multiple(_matrix(M), mbar, [1.0, 0.0])
    inverse_has_zero = np.array([[1.0, 0.0], [0.0, 1.0]])
    assert not no_multiple(_matrix(inverse_has_zero), mbar, [1.0, 1.0])
    skew = [1.0, 16.0]
    N = np.linalg.inv(np.array([[1.0, -0.5], [-0.5, 1.0]]))
    u = [8.5, 1.0]
    value = u @ (np.array([[1.0, -0.5], [-0.5, 1.0]]) * skew) @ np.array(u)
    assert no_multiple(_matrix(N), skew, u) == (value <= 0.0)


def test_a_number_is_rounded_downward_and_no_further_than_a_float() -> None:
    rng = np.random.default_rng(9)
    for _ in range(200):
        x = arb(float(rng.normal())) / arb(3) * arb(2) ** int(rng.integers(-60, 60))
        value = downward(x)
        assert x.lower() >= value
        assert not x.lower() >= float(np.nextafter(np.nextafter(value, np.inf), np.inf))
    ball = arb(1.0, 0.25)
    assert downward(ball) <= 0.75
    assert downward(ball) > 0.7499
    assert downward(arb(0.1)) == 0.1
    assert downward(arb("nan")) == downward(arb("-inf")) == -np.inf
    assert downward(arb(10) ** 400) == np.finfo(float).max
    assert downward(arb(1, 1) / arb(0, 1)) == -np.inf


# Precision ----------------------------------------------------------------------------------------------------------

SLIDE = """<robot name="r"><link name="a"/><link name="b"><inertial><mass value="{}"/>
<inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/></inertial></link>
<joint name="j0" type="prismatic"><parent link="a"/><child link="b"/><limit/></joint></robot>"""


@pytest.mark.parametrize(("mass", "verdict"), [("1." + "0" * 60 + "1", "true"), ("0." + "9" * 60, "false")])
def test_the_second_precision_decides_what_the_first_leaves_open(mass: str, verdict: str) -> None:
    # M̄ = 2 on a mass that differs from one in its sixtieth digit.
    balls = BallArm(description(SLIDE.format(mass)), ["j0"], {}, None)
    said = parsed_statement(1, "weighted")
    at = np.zeros(1)
    assert spot_checks._asked(balls, said, [2.0], at, at, [0.0], (128,)) == "open"
    assert spot_checks._asked(balls, said, [2.0], at, at, [0.0]) == verdict


def test_what_no_precision_decides_is_a_problem() -> None:
    balls = BallArm(description(SLIDE.format("1." + "0" * 300 + "1")), ["j0"], {}, None)
    said, chain = parsed_statement(1, "weighted"), chain_of(description(SLIDE.format("1")), ["j0"], {}, None)
    form = form_of(chain, np.array([2.0]), said, -np.ones(1), np.ones(1))
    with np.errstate(invalid="ignore"):
        found = spot_checks.spot_checks(
            balls,
            lambda q: least_eigenvalues(form, q),
            said,
            parsed_case(1),
            [2.0],
            np.zeros((1, 1)),
            np.zeros((1, 1)),
            0,
            0,
        )
    assert "could not be decided" in found.problem
    assert found.points == 0


# Spot checks --------------------------------------------------------------------------------------------------------


def _edge(kind: str, chain: Chain, mbar: Array, lower: Array, upper: Array) -> float:
    """The strongest scale (or level) that is true over a box, by samples and a climb."""
    rng = np.random.default_rng(0)
    none = np.zeros(len(mbar))

    def worst(q: Array) -> Array:
        M = chain.mass_matrix(q, none)
        root = np.sqrt(mbar)
        values = np.linalg.eigvalsh(root[:, None] * np.linalg.inv(M) * root)
        if kind == "weighted":
            return np.asarray(values[:, -1])
        if kind == "bounded":
            return np.asarray(-values[:, 0])
        N = 1.0 / mbar
        if kind == "lemma1":
            return np.asarray(-np.linalg.eigvalsh(M * (N[:, None] + N))[:, 0])
        return np.linalg.norm(np.eye(len(mbar)) - np.linalg.inv(M) * mbar, 2, axis=(1, 2))

    q = rng.uniform(lower, upper, (4000, len(mbar)))
    value = worst(q)
    for width in 0.3 ** np.arange(1, 14):
        best = q[np.argmax(value)]
        near = np.clip(best + width * rng.normal(size=(400, len(mbar))), lower, upper)
        q, value = np.concatenate((q, near)), np.concatenate((value, worst(near)))
    top = float(value.max())
    return {"weighted": 2.0 / top, "bounded": 1.0 + top, "lemma1": -top, "level": top}[kind]


def _claim(kind: str, edge: float, wrong: float) -> dict[str, Any]:
    """A statement that is too strong by a share, or too weak by it where it is negative."""
    if kind in ("weighted", "lemma1"):
        return {"scale": edge * (1.0 + wrong)}
    return {"level": 1.0 - (1.0 - edge) * (1.0 + wrong)}


def _uniform(joints: list[int]) -> np.ndarray:
    """A record that halves every cell at each of some joints in turn."""

    def part(left: list[int]) -> list[int]:
        return [left[0], *part(left[1:]), *part(left[1:])] if left else [255]

    return np.array(part(joints), dtype=np.uint8)


def _replayed(
    kind: str, seed: int, wrong: float, record: np.ndarray, monkeypatch: pytest.MonkeyPatch
) -> tuple[str, Contents]:
    chain, balls = arm(seed, 3)
    lower, upper = -np.ones(3), np.ones(3)
    mass = chain.mass_matrix(np.random.default_rng(1).uniform(lower, upper, (500, 3)), np.zeros(3))
    mbar = np.full(3, 0.9 * np.linalg.eigvalsh(mass).min())
    edge = _edge(kind, chain, mbar, lower, upper)
    said = statement(3, kind, **_claim(kind, edge, wrong))
    made = told(3, condition=condition_of(kind), mbar=hexed(mbar), statements=[said])

    def believed(form: Any, c: Array, r: Array) -> tuple[Array, Array, Array]:
        good, cost, least = box_bounds.holds(form, c, r)
        return np.ones_like(good), cost, least

    monkeypatch.setattr(statements, "holds", believed)
    result, problem = statements.replay_statement(
        made, made.statements[0], record, chain, balls, "", 0, lambda share: None
    )
    assert result.proven == (not problem)
    return problem, made


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_a_prover_that_is_wrong_by_a_percent_is_found_without_the_bounds_of_boxes(
    kind: str, seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    # 256 cells, in few of which the statement is false.
    record = _uniform([1, 2, 1, 2, 1, 2, 1, 2])
    problem, _ = _replayed(kind, seed, 0.01, record, monkeypatch)
    assert "not so" in problem
    problem, _ = _replayed(kind, seed, -0.01, record, monkeypatch)
    assert problem == ""


def test_the_cells_that_are_looked_at_are_the_hardest_and_some_drawn(monkeypatch: pytest.MonkeyPatch) -> None:
    chain, _ = arm(0, 2)
    made = told(2, statements=[statement(2)])
    form = form_of(chain, np.ones(2), made.statements[0], -np.ones(2), np.ones(2))
    least = np.random.default_rng(0).random(500)
    monkeypatch.setattr(
        statements,
        "holds",
        lambda form, c, r: (np.ones(len(c), dtype=bool), np.zeros_like(c), least[c[:, 0].astype(int)]),
    )
    replay = statements._Replay(form, 500, 8, 0, lambda share: None)
    centre = np.stack((np.arange(500.0), np.zeros(500)), axis=1)
    for start in range(0, 500, 100):
        assert replay.prove(centre[start : start + 100], np.ones((100, 2))) == ""
    numbers = replay.chosen()[0][:, 0].astype(int)
    assert set(np.argsort(least)[:4]) <= set(numbers)
    assert 5 <= len(numbers) <= 8


@pytest.mark.parametrize(("many", "least"), [(1, 64), (4, 16), (40, 4)])
def test_each_statement_has_its_share_of_points_and_progress_ends_at_all(
    many: int, least: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    chain, balls = arm(0, 2)
    made = told(2, mbar=hexed([1e-6, 1e-6]), statements=[statement(2)] * many)
    asked: list[int] = []

    def watched(*arguments: Any) -> spot_checks.Spots:
        asked.append(arguments[-1])
        return spot_checks.Spots()

    monkeypatch.setattr(statements, "spot_checks", watched)
    shares: list[float] = []
    result, problem = statements.replay_statement(
        made, made.statements[0], np.array([1, 255, 255], dtype=np.uint8), chain, balls, "", 0, shares.append
    )
    assert (problem, result.proven, result.boxes, result.halved) == ("", True, 2, 0)
    assert asked == [least]
    assert shares[-1] == 1.0
    assert all(0.0 < share <= 1.0 for share in shares)


def test_joints_on_the_base_ask_for_no_room() -> None:
    # Forty of them have one corner, not a million million.
    idle = SimpleNamespace(parent=np.full(40, -1), slides=np.zeros(40, dtype=bool))
    form = SimpleNamespace(chain=idle, exact=False, pairing=np.ones((1, 1)))
    batches = list(statements._Replay(form, 3, 2, 0, lambda share: None)._batches(np.zeros((3, 40))))  # type: ignore[arg-type]
    assert [batch.tolist() for batch in batches] == [[0, 1, 2]]


def _spots(kind: str, share: float = 1.0, largest: float = 0.0) -> spot_checks.Spots:
    """Of a statement at a share of M̄'s largest scale, or of the inverse of the least bound, up to an armature."""
    chain, balls = arm(0, 2)
    mass = chain.mass_matrix(np.random.default_rng(1).uniform(-1.0, 1.0, (2000, 2)), np.zeros(2))
    values = np.linalg.eigvalsh(mass)
    mbar = np.full(2, values.min())
    claim = {"scale": 2.0 * share} if kind == "weighted" else {"level": 1.0 - share * values.min() / values.max()}
    ends = case(2, armature_upper=[largest * values.max()] * 2)
    made = told(2, condition=condition_of(kind), cases=[ends], statements=[statement(2, kind, **claim)])
    said = made.statements[0]
    form = form_of(chain, mbar, said, -np.ones(2), np.ones(2))
    centres, halves = np.zeros((6, 2)), np.full((6, 2), 1.0)
    return spot_checks.spot_checks(
        balls, lambda q: least_eigenvalues(form, q), said, made.cases[0], mbar.tolist(), centres, halves, 0, 0
    )


def test_small_boxes_are_inside_the_cells_and_their_widths_are_told() -> None:
    found = _spots("weighted", 0.5)
    assert (found.points, found.boxes, found.problem) == (6, 6, "")
    assert found.widths is not None
    assert 0.0 < found.widths[0] <= found.widths[1] <= 0.1


def test_the_armature_that_is_evaluated_is_of_the_range_the_statement_is_used_for() -> None:
    rng = np.random.default_rng(0)
    ends = parsed_case(2, armature_lower=[0.1, 0.2], armature_upper=[0.3, 0.2])
    drawn = np.array([spot_checks._armature(parsed_statement(2, "bounded"), ends, rng) for _ in range(60)])
    assert drawn.min(axis=0).tolist() == [0.1, 0.2]
    assert drawn.max(axis=0).tolist() == [0.3, 0.2]
    assert len(set(drawn[:, 0])) > 3
    # Between the ends as well, whatever their distance.
    for width in (1e-3, 100.0):
        far = parsed_case(2, armature_lower=[0.1, 0.2], armature_upper=[0.1 + width, 0.2])
        shares = [(spot_checks._armature(parsed_statement(2, "bounded"), far, rng)[0] - 0.1) / width for _ in range(90)]
        inside = [share for share in shares if 1e-9 < share < 1.0 - 1e-9]
        assert len(inside) > 10
        assert np.ptp(inside) > 0.5
    own = parsed_statement(2, "level", armature=[0.5, 0.0], slack=[0.25, 0.0])
    drawn = np.array([spot_checks._armature(own, ends, rng) for _ in range(60)])
    assert drawn.min(axis=0).tolist() == [0.5, 0.0]
    assert drawn.max(axis=0).tolist() == [0.75, 0.0]


def test_a_statement_that_is_false_at_an_end_of_the_armature_is_found() -> None:
    # `bounded` without the slack: true at the least armature, and false at the largest.
    assert _spots("bounded", 0.9).problem == ""
    wrong = _spots("bounded", 0.9, 1.0)
    assert "not so" in wrong.problem
    assert wrong.points < 6


def test_the_header_that_these_tests_build_is_one() -> None:
    assert told(2).model_dump()["joints"] == tuple(header(2)["joints"])
