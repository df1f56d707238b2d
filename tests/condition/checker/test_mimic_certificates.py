"""Certificates of joints that mimic others: they replay, they say of what, and none that was tampered with is false."""

from __future__ import annotations

import hashlib
import io
import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from arm_urdf import inertial, joint, link, robot, write
from certificate_truth import untruths
from coupled_urdf import coupled_tree, gripper, parallelogram
from flint import arb

from asmc_pin import Arm, SampledLoop, bounds, certify, certify_loop, check, load_arm
from asmc_pin.condition.certificate.certificate_result import CertificateResult
from asmc_pin.condition.certificate.container import digest, numbers, read
from asmc_pin.condition.checker.balls.balls import BallArm
from asmc_pin.condition.checker.boxes.pieces_of_statement import image
from asmc_pin.condition.checker.reading.coupled_joints import following
from asmc_pin.condition.checker.reading.link_chain import chain_of
from asmc_pin.condition.checker.reading.urdf_text import Unreadable, description


def bearable(arm: Arm, share: float) -> Any:
    """An M̄ that satisfies the conditions at that share of what single joints feel least."""
    mass = arm.mass_matrix(np.random.default_rng(0).uniform(*arm.box, (500, arm.nv)))
    return share / np.diagonal(np.linalg.inv(mass), axis1=1, axis2=2).max(axis=0)


def moving(arm: Arm) -> list[str]:
    return list(arm.model.names)[1:]


@pytest.mark.parametrize("seed", range(6))
def test_the_checker_reads_the_same_arm_by_its_own_means(tmp_path: Path, seed: int) -> None:
    rng = np.random.default_rng(seed)
    text = coupled_tree(rng, joints=6, followers=3, chained=True)
    arm = load_arm(write(tmp_path, text))
    told = description(arm.urdf_text), arm.joint_names, {}, None, moving(arm)
    chain, balls = chain_of(*told), BallArm(*told)
    q = rng.uniform(*arm.box)
    assert chain.arm_mass(q) == pytest.approx(arm.mass_matrix(q), rel=1e-12, abs=1e-13)
    mass = balls.mass_matrix([arb(float(x)) for x in q], [arb(0)] * arm.nv)
    found = [[float(mass[i, j].mid()) for j in range(arm.nv)] for i in range(arm.nv)]
    assert np.array(found) == pytest.approx(arm.mass_matrix(q), rel=1e-12, abs=1e-13)
    low, high = arm.box
    ends = image(chain, low, high)
    joints = arm.tree.coupling.joints(rng.uniform(low, high, (200, arm.nv)))
    assert np.all((joints >= ends[0]) & (joints <= ends[1]))


@pytest.mark.parametrize("condition", ["lemma1", "weighted"])
@pytest.mark.parametrize("seed", [0, 1, 3])
def test_what_is_proven_of_followers_is_proven_again(tmp_path: Path, condition: Any, seed: int) -> None:
    rng = np.random.default_rng(70 + seed)
    arm = load_arm(write(tmp_path, coupled_tree(rng, joints=4, followers=2, chained=seed == 0)), armature=0.05)
    low, high = arm.box
    begin = low + 0.6 * rng.random(arm.nv) * (high - low)
    ends = [0.05 if kind == "revolute" else 0.02 for kind in arm.joint_kinds]
    box = {name: (b, b + 0.3) for name, b in zip(arm.joint_names, begin.tolist(), strict=True)}
    rotors = [(0.05, 0.05 + end) for end in ends]
    result = certify(arm, bearable(arm, 0.5), condition=condition, box=box, armature=rotors, gap=0.3, budget=20.0)
    assert result.scale_proven > 0.0
    assert result.proofs
    found = check(result.save(tmp_path / "proof.cert"))
    assert found.valid, found.problems
    assert found.hypotheses is not None
    assert dict(found.hypotheses.mimics) == {
        name: (m.joint, pytest.approx(m.multiplier), pytest.approx(m.offset)) for name, m in arm.mimics.items()
    }
    assert untruths(tmp_path / "proof.cert", found.to_json_dict(), tmp_path) == []


@pytest.fixture(scope="module")
def proven(tmp_path_factory: pytest.TempPathFactory) -> CertificateResult:
    """Of a gripper, one finger of which follows the other."""
    arm = load_arm(write(tmp_path_factory.mktemp("mimic"), gripper()), armature=0.02)
    return certify(arm, bearable(arm, 0.9), condition="weighted", gap=0.3, budget=20.0, levels=False)


def test_a_parallelogram_whose_follower_bears_less_than_nothing_is_proven_again(tmp_path: Path) -> None:
    arm = load_arm(write(tmp_path, parallelogram()), armature=0.02)
    result = certify(arm, bearable(arm, 0.9), budget=20.0, levels=False)
    pieces = result.proofs[0].weights
    assert len(pieces) > 2
    assert min(map(min, pieces)) < 0.0
    found = check(result.save(tmp_path / "proof.cert"))
    assert found.valid, found.problems
    assert found.statements[0].boxes == result.proofs[0].boxes == result.boxes >= len(pieces)


def test_bounds_and_a_loop_are_proven_again_and_nothing_is_said_of_velocity_forces(tmp_path: Path) -> None:
    arm = load_arm(write(tmp_path, gripper()), armature=0.02)
    report = bounds(arm, gap=0.3, budget=20.0)
    found = check(report.save(tmp_path / "bounds.cert"))
    assert found.valid, found.problems
    said = found.to_json_dict()
    assert said["coriolis"] == [None, None]
    assert said["lower"][0] == pytest.approx(report.lower.proven)
    assert untruths(tmp_path / "bounds.cert", said, tmp_path) == []
    proof = certify_loop(arm, SampledLoop(0.5 * bearable(arm, 0.9), 5.0, 5.0, 1e-3), budget=20.0)
    found = check(proof.save(tmp_path / "loop.cert"))
    assert found.valid, found.problems
    assert found.to_json_dict()["verdict"] == "stable"


def tampered(
    result: CertificateResult,
    folder: Path,
    change: Callable[[dict[str, Any], list[Any]], None] = lambda _header, _records: None,
    text: Callable[[str], str] = lambda urdf: urdf,
) -> Path:
    """A changed copy in which all that can be made to fit fits: hashes, digest, and samples of the arm inside."""
    path = result.save(folder / "proof.cert")
    container = read(path)
    header, urdf, records = container.header, text(container.urdf), list(container.records)
    change(header, records)
    header["urdf_sha256"] = hashlib.sha256(urdf.encode()).hexdigest()
    try:
        robot = description(urdf)
        for case in header["cases"]:
            chain = chain_of(robot, header["joints"], {}, None, header.get("moving", ()))
            q = np.array([[float.fromhex(x) for x in row] for row in case["sample_q"]])
            case["sample_mass"] = numbers(chain.arm_mass(q))
    except Unreadable:
        pass
    header["digest"] = digest(header, urdf, records)
    content = {f"record_{k}": record for k, record in enumerate(records)}
    content["header"] = np.frombuffer(json.dumps(header).encode(), dtype=np.uint8)
    content["urdf"] = np.frombuffer(urdf.encode(), dtype=np.uint8)
    buffer = io.BytesIO()
    np.savez_compressed(buffer, allow_pickle=False, **content)
    path.write_bytes(buffer.getvalue())
    return path


def _mimic(**changes: str) -> Callable[[str], str]:
    def change(urdf: str) -> str:
        for key, value in changes.items():
            urdf, count = re.subn(rf'(<mimic[^>]*{key}=")[^"]*"', rf'\g<1>{value}"', urdf)
            assert count == 1
        return urdf

    return change


OTHER_ARMS: dict[str, Callable[[str], str]] = {
    "another ratio": _mimic(multiplier="1.4"),
    "a ratio far away": _mimic(multiplier="3.0"),
    "the other way": _mimic(multiplier="-1.0"),
    "half of it": _mimic(multiplier="0.5"),
    "no ratio": _mimic(multiplier="0"),
    "another offset": _mimic(offset="0.5"),
    "an offset far away": _mimic(offset="9.0"),
    "another joint": _mimic(joint="lift"),
    "a joint after it": _mimic(joint="roll"),
    "itself": _mimic(joint="right_finger"),
    "nobody": _mimic(joint="nobody"),
    "a text for a ratio": _mimic(multiplier="1.0 "),
    "no follower": lambda urdf: re.sub(r"<mimic[^>]*/>", "", urdf),
    "followers of each other": lambda urdf: urdf.replace(
        'name="left_finger" type="prismatic">', 'name="left_finger" type="prismatic"><mimic joint="right_finger"/>'
    ),
    "two at once": lambda urdf: re.sub(r"(<mimic[^>]*/>)", r'\g<1><mimic joint="lift"/>', urdf),
}


@pytest.mark.parametrize("what", OTHER_ARMS)
def test_of_another_coupling_it_is_valid_only_where_it_is_true(
    what: str, proven: CertificateResult, tmp_path: Path
) -> None:
    path = tampered(proven, tmp_path, text=OTHER_ARMS[what])
    assert read(path).urdf != proven.cases[0].domain.arm.urdf_text
    found = check(path)
    if found.valid:
        assert untruths(path, found.to_json_dict(), tmp_path) == []


@pytest.mark.parametrize(
    "what", ["no ratio", "itself", "nobody", "no follower", "followers of each other", "two at once"]
)
def test_what_the_urdf_does_not_say_is_never_valid(what: str, proven: CertificateResult, tmp_path: Path) -> None:
    assert not check(tampered(proven, tmp_path, text=OTHER_ARMS[what])).valid


def _statement(change: Callable[[dict[str, Any]], None]) -> Callable[[dict[str, Any], list[Any]], None]:
    return lambda header, _records: change(header["statements"][0])


def _scaled(row: list[str], factor: float) -> list[str]:
    return [float(float.fromhex(x) * factor).hex() for x in row]


FORGED: dict[str, Callable[[dict[str, Any], list[Any]], None]] = {
    "less is borne": _statement(lambda s: s.update(weights=[_scaled(row, 0.999) for row in s["weights"]])),
    "a little less is borne": _statement(
        lambda s: s.update(weights=[_scaled(row, 1.0 - 1e-12) for row in s["weights"]])
    ),
    "nothing is borne": _statement(lambda s: s.update(weights=[_scaled(row, 0.0) for row in s["weights"]])),
    "no weights": _statement(lambda s: s.pop("weights")),
    "too many weights": _statement(lambda s: s["weights"].append(s["weights"][0])),
    "a row too short": _statement(lambda s: s.update(weights=[row[:-1] for row in s["weights"]])),
    "a larger scale": lambda header, _: (
        header["statements"][0].update(scale=1.3 * header["scale_refuted"]),
        header.update(scale_proven=1.3 * header["scale_refuted"]),
    ),  # type: ignore[func-returns-value]
    "a joint less that moves": lambda header, _: header["moving"].pop(),
    "nothing follows": lambda header, _: header.pop("moving"),
    "a follower with a coordinate": lambda header, _: header["joints"].append("right_finger"),
    "joints in another order": lambda header, _: header["moving"].reverse(),
    "a name that is not there": lambda header, _: header["moving"].append("nobody"),
    "a record cut short": lambda _, records: records.__setitem__(0, records[0][:-1]),
    "a record that goes on": lambda _, records: records.__setitem__(0, np.append(records[0], np.uint8(255))),
    "a piece of another joint": lambda _, records: records.__setitem__(0, np.insert(records[0], 0, np.uint8(9))),
}


@pytest.mark.parametrize("what", FORGED)
def test_no_forged_part_of_it_passes(what: str, proven: CertificateResult, tmp_path: Path) -> None:
    found = check(tampered(proven, tmp_path, FORGED[what]))
    assert not found.valid
    assert found.problems


@pytest.mark.parametrize("ends", [(0.0, 0.4), (-0.3, 0.04), (0.0, 3.0)])
def test_of_a_larger_box_it_is_valid_only_where_it_is_true(
    ends: tuple[float, float], proven: CertificateResult, tmp_path: Path
) -> None:
    def larger(header: dict[str, Any], _records: list[Any]) -> None:
        for key, value in zip(("lower", "upper"), ends, strict=True):
            header["cases"][0][key][2] = float(value).hex()

    path = tampered(proven, tmp_path, larger)
    found = check(path)
    if found.valid:
        assert untruths(path, found.to_json_dict(), tmp_path) == []


def test_more_borne_than_needed_is_still_a_proof(proven: CertificateResult, tmp_path: Path) -> None:
    more = _statement(lambda s: s.update(weights=[_scaled(row, 1.0 + 1e-9) for row in s["weights"]]))
    assert check(tampered(proven, tmp_path, more)).valid


def test_a_follower_that_was_freed_is_in_no_certificate(tmp_path: Path) -> None:
    arm = load_arm(write(tmp_path, gripper()), lock={"right_finger": "free"}, armature=0.02)
    result = certify(arm, bearable(arm, 0.5), gap=0.5, budget=10.0, levels=False)
    with pytest.raises(Exception, match="mimic others in the URDF and were freed: right_finger"):
        result.save(tmp_path / "proof.cert")


@pytest.mark.parametrize(("ratio", "read_there"), [("1.5e-6", True), ("-9e5", True), ("9e-7", False), ("1.1e6", False)])
def test_a_follower_that_hardly_moves_or_hardly_lets_its_leader_move_is_not_read(ratio: str, read_there: bool) -> None:
    limit = '<limit lower="-2" upper="2" effort="50" velocity="3"/>'
    mimic = f'<mimic joint="lead" multiplier="{ratio}"/>'
    text = robot(
        link("base"),
        link("a", inertial()),
        link("b", inertial()),
        joint("lead", "base", "a"),
        joint("tail", "a", "b", extra=limit + mimic),
    )
    if read_there:
        assert following(description(text), ["lead"], ["lead", "tail"]).follows
    else:
        with pytest.raises(Unreadable, match="by a ratio not read here"):
            following(description(text), ["lead"], ["lead", "tail"])
