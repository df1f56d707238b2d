"""Proofs of the frozen loop without gravity: their two numbers, their hypotheses, and what no proof may say."""

from __future__ import annotations

import copy
import json
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from certificate_truth import untruths
from condition_cases import chain

from asmc_pin import LoopProof, SampledLoop, certify_loop, check, load_arm
from asmc_pin.cli import main
from asmc_pin.condition.certificate.container import Container, digest, read
from asmc_pin.condition.checker.loop_conclusion import ends_of_stability as checked_ends
from asmc_pin.errors import ParameterError, ResultError
from asmc_pin.sampled import closed_loop, spectral_radius
from asmc_pin.sampled.proof.loop_certificate import ends_of_stability

SENTENCE = "the loop frozen at every q of the box, without gravity, is stable"
UR5_MBAR = 0.8 * np.array([0.1483264, 0.1674553, 0.1504278, 0.0810652, 0.0933441, 0.0171369])


@pytest.fixture(scope="module")
def ur5() -> LoopProof:
    loop = SampledLoop(UR5_MBAR, 10.0, 10.0, 1e-3)
    return certify_loop(load_arm("ur5"), loop, armature=[(0.1, 0.3)] * 6, payload=(0.0, 2.0))


def _radius(a: float, loop: SampledLoop) -> float:
    """Spectral radius of one joint with inertia 1/a and M̄ = 1, from its full map."""
    mode = SampledLoop(np.ones(1), loop.ks[:1], loop.beta[:1], loop.period)
    return float(np.abs(np.linalg.eigvals(closed_loop(np.array([[1.0 / a]]), mode).matrix)).max())


@pytest.mark.parametrize("seed", range(40))
def test_a_mode_is_stable_just_inside_the_two_numbers_and_unstable_just_outside(seed: int) -> None:
    rng = np.random.default_rng(seed)
    period = 10.0 ** rng.uniform(-3.5, -2.0)
    ks, beta = (10.0 ** rng.uniform(-1.5, 0.3, 2) / period).tolist()
    loop = SampledLoop(np.ones(1), ks, beta, period)
    inverse_high, inverse_low = ends_of_stability(ks, beta, period)
    low, high = float(1 / inverse_low), float(1 / inverse_high)
    if low >= high:  # no M̄ is stable with such gains
        assert min(_radius(a, loop) for a in np.geomspace(0.1 * high, 10.0 * low, 60)) >= 1.0
        return
    width = min(1e-4 * (high - low), 1e-4 * low)
    assert _radius(low + width, loop) < 1.0 < _radius(low - width, loop)
    assert _radius(high - width, loop) < 1.0 < _radius(high + width, loop)
    assert all(_radius(a, loop) < 1.0 for a in np.linspace(low + width, high - width, 20))


def test_the_checker_has_the_same_two_numbers_by_itself() -> None:
    rng = np.random.default_rng(0)
    for ks, beta, period in rng.uniform(1e-4, 100.0, (50, 3)).tolist():
        assert ends_of_stability(ks, beta, period) == checked_ends(ks, beta, period)
    assert ends_of_stability(20.0, 20.0, 0.5) == (Fraction(11, 2), Fraction(7, 10))


@pytest.mark.parametrize("seed", range(6))
def test_no_configuration_contradicts_a_proven_loop(seed: int, tmp_path: Path) -> None:
    rng = np.random.default_rng(seed)
    joints = 2 + seed % 3
    arm = chain(tmp_path, seed, joints, prismatic=seed % 2 == 1)
    q = rng.uniform(*arm.box, (300, joints))
    least = np.linalg.eigvalsh(arm.mass_matrix(q))[:, 0].min()
    mbar = least * rng.uniform(0.3, 1.9) * np.ones(joints)
    gain = 10.0 ** rng.uniform(0.0, 2.0)
    loop = SampledLoop(mbar, gain, gain * rng.uniform(0.3, 3.0), 1e-3)
    ranges: dict[str, Any] = {"armature": [(0.0, 0.02)] * joints, "payload": (0.0, 0.5)}
    proof = certify_loop(arm, loop, budget=20.0, **ranges)
    ends = [arm.replace(payload=load, armature=a) for load in (None, 0.25, 0.5) for a in (0.0, 0.01, 0.02)]
    worst = max(float(spectral_radius(end.mass_matrix(q), loop).max()) for end in ends)
    assert proof.verdict != "undecided"
    if proof.verdict == "stable":
        assert worst < 1.0
    else:
        low, high = proof.stable_between
        assert proof.seen_between[0] <= low or proof.seen_between[1] >= high
    replayed = check(proof.save(tmp_path / "loop.cert"))
    assert replayed.valid, replayed.problems
    assert replayed.verdict == proof.verdict


def test_a_loop_that_is_refuted_is_unstable_where_the_search_found_it(tmp_path: Path) -> None:
    arm = load_arm("ur5")
    loop = SampledLoop(UR5_MBAR, 100.0, 100.0, 1e-3)
    proof = certify_loop(arm, loop)
    assert proof.verdict == "unstable"
    assert proof.proofs == ()
    values = (1.0 / proof.seen_between[1], 1.0 / proof.seen_between[0])
    seen = [np.array([float.fromhex(x) for x in at["q"]]) for at in proof.seen_at]
    radii = [float(spectral_radius(arm.mass_matrix(q), loop)) for q in seen]
    assert max(radii) >= 1.0
    assert values[0] < values[1]
    found = check(proof.save(tmp_path / "loop.cert"))
    assert found.valid
    assert found.verdict == "unstable"


def test_what_is_proven_and_what_is_not_stands_in_one_place(ur5: LoopProof, tmp_path: Path) -> None:
    assert ur5.verdict == "stable"
    assert any(SENTENCE in line for line in ur5.lines())
    found = check(ur5.save(tmp_path / "loop.cert"))
    assert found.valid, found.problems
    text = str(found)
    assert SENTENCE in text
    assert "of the moving arm" in text
    said = json.loads(json.dumps(found.to_json_dict(), allow_nan=False))
    assert (said["verdict"], said["ks"], said["beta"], said["period"]) == ("stable", 10.0, 10.0, 1e-3)
    assert said["armature"] == [[0.1, 0.3]] * 6
    assert said["payload"]["mass"] == [0.0, 2.0]
    low, high = said["proven_between"]
    assert low < ur5.seen_between[0] < ur5.seen_between[1] < high


@pytest.mark.parametrize(
    "change",
    [
        {"ks": 400.0},
        {"beta": 400.0},
        {"period": 0.05},
        {"ks": -10.0},
        {"mbar": 8.0},
        {"mbar": 0.001},
        {"scale": 0.5},
        {"verdict": "unstable"},
        {"verdict": "undecided"},
        {"drop": 0},
        {"drop": 2},
        {"kinds": True},
        {"armature": 0.0},
    ],
)
def test_a_forged_loop_is_refused(change: dict[str, Any], ur5: LoopProof, tmp_path: Path) -> None:
    (what, value), *_ = change.items()
    container = read(ur5.save(tmp_path / "loop.cert"))
    header, records = copy.deepcopy(container.header), list(container.records)
    if what in ("ks", "beta", "period"):
        header[what] = float(value).hex()
    elif what == "mbar":
        header["mbar"] = [(value * float.fromhex(m)).hex() for m in header["mbar"]]
    elif what == "scale":
        for statement in header["statements"]:
            statement["scale"] *= value
    elif what == "verdict":
        header["verdict"] = value
    elif what == "drop":
        del header["statements"][value], records[value]
    elif what == "kinds":
        for statement in header["statements"]:
            statement["kind"] = {"weighted": "bounded", "bounded": "weighted"}[statement["kind"]]
            statement["level"] = 0.5
    else:
        for case in header["cases"]:
            case["armature_lower"] = [float(value).hex()] * 6
    path = _write(Container(header, container.urdf, records), tmp_path / "forged.cert")
    found = check(path)
    assert not found.valid
    assert found.problems
    assert SENTENCE not in str(found)


@pytest.mark.parametrize("ks", [9.0, 1e-9])
def test_gains_for_which_the_same_statements_suffice_are_stable_too(ks: float, ur5: LoopProof, tmp_path: Path) -> None:
    container = read(ur5.save(tmp_path / "loop.cert"))
    # Less of k_s moves both ends outward; what is proven under gravity is of the one k_s.
    header = {**container.header, "ks": ks.hex(), "gravity": None}
    path = _write(Container(header, container.urdf, container.records), tmp_path / "other.cert")
    found = check(path)
    assert found.verdict == "stable"
    assert untruths(path, found.to_json_dict(), tmp_path) == []


def _write(container: Container, path: Path) -> Path:
    header = dict(container.header)
    header["digest"] = digest(header, container.urdf, container.records)
    content = {f"record_{k}": record for k, record in enumerate(container.records)}
    content["header"] = np.frombuffer(json.dumps(header).encode(), dtype=np.uint8)
    content["urdf"] = np.frombuffer(container.urdf.encode(), dtype=np.uint8)
    with path.open("wb") as file:
        np.savez(file, allow_pickle=False, **content)  # type: ignore[arg-type]
    return path


@pytest.mark.parametrize(
    ("name", "options"),
    [
        ("ks", {"ks": [10.0, 11.0]}),
        ("acceleration", {"acceleration": "position"}),
        ("filter_hz", {"filter_hz": 100.0}),
        ("delay", {"delay": 0.5}),
    ],
)
def test_a_loop_that_is_not_the_plain_one_is_refused(name: str, options: dict[str, Any]) -> None:
    gains: dict[str, Any] = {"mbar": np.full(2, 0.01), "ks": 10.0, "beta": 10.0, "period": 1e-3, **options}
    with pytest.raises(ParameterError, match=name):
        certify_loop(load_arm("two_link"), SampledLoop(**gains))


def test_what_is_not_decided_is_not_written(tmp_path: Path) -> None:
    arm = load_arm("panda")
    q = np.random.default_rng(0).uniform(*arm.box, (2000, 7))
    mbar = 1.5 * np.linalg.eigvalsh(arm.mass_matrix(q)).min() * np.ones(7)
    proof = certify_loop(arm, SampledLoop(mbar, 1.0, 1.0, 1e-3), budget=1e-3)
    assert proof.verdict == "undecided"
    with pytest.raises(ResultError, match="nothing is proven"):
        proof.save(tmp_path / "none.cert")


# The command line ---------------------------------------------------------------------------------------------------


@pytest.fixture
def asmc_pin(capfd: pytest.CaptureFixture[str]) -> Callable[..., tuple[int, str, str]]:
    def run(*arguments: str) -> tuple[int, str, str]:
        with pytest.raises(SystemExit) as end:
            main(list(arguments))
        out, err = capfd.readouterr()
        return int(end.value.code or 0), out, err

    return run


def test_a_proven_loop_is_certified_and_its_certificate_checks(
    asmc_pin: Callable[..., tuple[int, str, str]], tmp_path: Path
) -> None:
    path = tmp_path / "loop.cert"
    gains = ["--mbar", "0.1", "--ks", "20", "--beta", "20", "--period", "0.001"]
    asked = ["stability", "ur5", "--armature", "0.1", *gains]
    status, out, _ = asmc_pin(*asked, "--certify", "--certificate", str(path), "--json")
    said = json.loads(out)
    assert (status, said["kind"], said["verdict"]) == (0, "certified", "stable")
    assert "without gravity" in said["proof"]["about"]
    status, out, _ = asmc_pin("check", str(path))
    assert status == 0
    assert SENTENCE in out
    status, out, _ = asmc_pin(*asked, "--json")
    assert (json.loads(out)["kind"], status) == ("searched", 0)


def test_bounds_are_printed_and_their_certificate_checks(
    asmc_pin: Callable[..., tuple[int, str, str]], tmp_path: Path
) -> None:
    path = tmp_path / "bounds.cert"
    status, out, _ = asmc_pin("bounds", "two_link", "--scale", "1,2", "--certificate", str(path), "--json")
    said = json.loads(out)
    assert status == 0
    assert set(said) >= {"arm", "joints", "lower", "upper", "coriolis", "condition_number"}
    assert said["lower"][0] < said["lower"][1] < said["upper"][1] < said["upper"][0]
    status, out, _ = asmc_pin("check", str(path), "--json")
    assert status == 0
    assert json.loads(out)["lower"][0] == said["lower"][0]
    assert asmc_pin("bounds", "two_link", "--scale", "1,2,3")[0] == 2
    assert asmc_pin("bounds", "panda", "--budget", "0.001")[0] == 3


def test_a_loop_for_another_number_of_joints_is_refused() -> None:
    with pytest.raises(ParameterError, match="M̄ of 1 values given, 2 expected"):
        certify_loop(load_arm("two_link"), SampledLoop(0.01, 5.0, 300.0, 1e-3))
