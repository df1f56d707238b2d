"""Replaying a certificate: a sound one passes; whatever is changed in it is noticed, also if it is signed anew."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from certificate_cases import ur5_certificate
from certificate_files import rewrite
from condition_cases import chain

from asmc_pin import load_arm
from asmc_pin.arms import Payload
from asmc_pin.condition.certificate import certify
from asmc_pin.condition.certificate.container import digest, numbers, read
from asmc_pin.condition.checker import check
from asmc_pin.condition.checker.boxes.bisection import Broken, cells
from asmc_pin.condition.checker.reading.header_parts import Load
from asmc_pin.condition.checker.reading.link_chain import chain_of
from asmc_pin.condition.checker.reading.urdf_text import Unreadable, description
from asmc_pin.errors import ResultError


@pytest.fixture(scope="module")
def certificate(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return ur5_certificate().save(tmp_path_factory.mktemp("certificate") / "ur5.cert")


def test_a_certificate_is_replayed_box_by_box_on_another_route(certificate: Path) -> None:
    found = check(certificate)
    assert found.valid, found.problems
    assert found.hypotheses is not None
    assert found.conclusion is not None
    assert (found.hypotheses.arm, found.hypotheses.condition, found.verdict) == ("ur5", "weighted", "holds")
    assert found.conclusion.scale_proven == ur5_certificate().scale_proven
    assert found.conclusion.lower == pytest.approx(ur5_certificate().lower, rel=1e-12)
    assert sum(s.boxes for s in found.statements if s.level == 1.0) == ur5_certificate().boxes
    assert all(s.spots.points >= 2 and s.spots.boxes >= 2 for s in found.statements)
    assert json.loads(json.dumps(found.to_json_dict()))["valid"] is True
    assert "valid" in found.lines()[0]
    assert certificate.stat().st_size < 20_000


def _scale(header: dict[str, Any], factor: float) -> None:
    header["scale_proven"] *= factor
    for statement in header["statements"]:
        if statement["level"] == 1.0:
            statement["scale"] *= factor


def _set(key: str, value: Any) -> Callable[[dict[str, Any], list[Any]], None]:
    return lambda header, records: header.__setitem__(key, value)


def _in_case(key: str, value: Any) -> Callable[[dict[str, Any], list[Any]], None]:
    return lambda header, records: header["cases"][0].__setitem__(key, value)


CHANGES: dict[str, Callable[[dict[str, Any], list[Any]], None]] = {
    "a larger scale": lambda header, records: _scale(header, 1.02),
    "a larger scale without a statement": _set("scale_proven", 1.03),
    "another M̄": lambda header, records: header.update(mbar=numbers(1.05 * np.array(ur5_certificate().mbar))),
    "another condition": _set("condition", "lemma1"),
    "a lower level": _set("upper", 0.9),
    "a level that is not proven": lambda header, records: (
        header.update(upper=0.934),
        [s.update(level=0.934) for s in header["statements"] if s["level"] < 1.0],
    ),
    "a better norm": _set("lower", 0.9),
    "a payload": _in_case(
        "payload",
        {"mass": "0x1p0", "com": numbers(np.zeros(3)), "inertia": numbers(np.zeros(6)), "link": "wrist_3_link"},
    ),
    "armature that is not there": lambda header, records: [
        s.update(armature=numbers(np.full(6, 0.1))) for s in header["statements"]
    ],
    "a smaller counter-example": _set("scale_refuted", 0.9),
    "a verdict": _set("verdict", "violated"),
    "joints in another order": lambda header, records: header["joints"].reverse(),
    "a record with a box left out": lambda header, records: records.__setitem__(0, np.delete(records[0], -1)),
    "a record with a box too many": lambda header, records: records.__setitem__(0, np.repeat(records[0], 2)),
    "a record that never halves": lambda header, records: records.__setitem__(0, np.array([255], dtype=np.uint8)),
    "a record of another arm": lambda header, records: records.__setitem__(0, np.array([9, 255, 255], dtype=np.uint8)),
    "a proof less": lambda header, records: (records.pop(), header["statements"].pop()),
    "a proof without its statement": lambda header, records: header["statements"].pop(),
    "no header to speak of": lambda header, records: header.pop("cases"),
}
REPLAYED_ALL_THE_SAME = {"a record that never halves"}
"""What is changed there is only how much work is left to the checker, which does it."""


@pytest.mark.parametrize("what", CHANGES)
def test_a_changed_certificate_is_refused_even_with_a_digest_that_fits(
    what: str, certificate: Path, tmp_path: Path
) -> None:
    found = check(rewrite(certificate, tmp_path / "changed.cert", CHANGES[what]))
    assert found.valid == (what in REPLAYED_ALL_THE_SAME), (what, found.problems)
    assert all(problem and "\n" not in problem for problem in found.problems)


def test_any_change_is_noticed_by_the_digest(certificate: Path, tmp_path: Path) -> None:
    def change(header: dict[str, Any], records: list[Any]) -> None:
        header["scale_proven"] *= 1.0 - 1e-15

    found = check(rewrite(certificate, tmp_path / "changed.cert", change, sign=False))
    assert not found.valid
    assert "digest" in found.problems[0]


def test_another_urdf_is_noticed(certificate: Path, tmp_path: Path) -> None:
    container = read(certificate)
    header, urdf, records = container.header, container.urdf, container.records
    heavier = urdf.replace("8.393", "8.4")
    assert heavier != urdf
    content = {f"record_{k}": record for k, record in enumerate(records)}
    header["digest"] = digest(header, heavier, records)
    content["header"] = np.frombuffer(json.dumps(header).encode(), dtype=np.uint8)
    content["urdf"] = np.frombuffer(heavier.encode(), dtype=np.uint8)
    np.savez(tmp_path / "other.npz", allow_pickle=False, **content)
    found = check(tmp_path / "other.npz")
    assert any("hash" in problem for problem in found.problems)
    assert any("another arm" in problem for problem in found.problems)


def test_ranges_locks_and_slides_are_replayed(tmp_path: Path) -> None:
    sliding = chain(tmp_path, 4, 3, prismatic=True)
    q = np.random.default_rng(0).uniform(*sliding.box, (500, 3))
    mbar = np.full(3, 0.7 * np.linalg.eigvalsh(sliding.mass_matrix(q)).min())
    load = Payload(1.0, com=(0.02, 0.0, 0.05), inertia=(0.01, 0.001, 0.0, 0.02, 0.0, 0.015))
    for condition in ("lemma1", "weighted"):
        found = certify(
            sliding,
            mbar,
            condition=condition,
            payload=(0.0, 1.0),
            armature=[(0.0, 0.1), 0.0, (0.1, 0.2)],
            gap=0.1,
            budget=10.0,
        )
        replayed = check(found.save(tmp_path / "ranges.cert"))
        assert replayed.valid, replayed.problems
    found = certify(sliding.replace(payload=load), mbar[:2], lock={"j2": (0.1, 0.5)}, gap=0.2, budget=10.0)
    replayed = check(found.save(tmp_path / "locks.cert"))
    assert replayed.valid, replayed.problems
    assert {s.case for s in replayed.statements} == {"j2 locked at 0.1", "j2 locked at 0.5"}


def test_a_violation_alone_can_be_certified(tmp_path: Path) -> None:
    found = certify(load_arm("double_pendulum"), 5.0, condition="weighted", gap=0.5, budget=1e-4)
    assert found.verdict == "violated"
    replayed = check(found.save(tmp_path / "violated.cert"))
    assert replayed.valid, replayed.problems


def test_what_is_no_certificate_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ResultError, match="cannot read"):
        check(tmp_path / "missing.cert")
    text = tmp_path / "text.cert"
    text.write_text("not at all", encoding="utf-8")
    with pytest.raises(ResultError, match="not a certificate"):
        check(text)
    np.savez(
        tmp_path / "other.npz", header=np.frombuffer(b'{"format": "other"}', dtype=np.uint8), urdf=np.zeros(0, np.uint8)
    )
    with pytest.raises(ResultError, match="format"):
        check(tmp_path / "other.npz")


def test_nothing_proven_is_nothing_written(tmp_path: Path) -> None:
    found = certify(load_arm("panda"), 1e-3, gap=0.01, budget=1e-6)
    assert found.verdict == "undecided"
    with pytest.raises(ResultError, match="nothing is proven"):
        found.save(tmp_path / "nothing.cert")


@pytest.mark.parametrize("name", ["ur5", "panda", "z1", "kinova", "xarm7", "so100", "two_link"])
def test_the_checkers_own_reading_of_a_urdf_gives_pinocchios_inertia(name: str) -> None:
    arm = load_arm(
        name, payload={"mass": 1.0, "com": (0.01, 0.02, 0.03), "inertia": (0.01, 0.001, 0.002, 0.02, 0.003, 0.015)}
    )
    assert arm.payload is not None
    payload = Load.model_construct(**{key: getattr(arm.payload, key) for key in ("mass", "com", "inertia", "link")})
    read_anew = chain_of(description(arm.urdf_text), arm.joint_names, arm.locked, payload)
    q = np.random.default_rng(0).uniform(-3.0, 3.0, (20, arm.nv))
    mass = arm.mass_matrix(q)
    assert np.abs(read_anew.mass_matrix(q, arm.armature) - mass).max() < 1e-13 * np.abs(mass).max()


def test_a_urdf_that_is_another_arms_is_unreadable() -> None:
    arm = load_arm("ur5")
    with pytest.raises(Unreadable, match="neither moves nor locks"):
        chain_of(description(arm.urdf_text), arm.joint_names[:-1], {}, None)
    with pytest.raises(Unreadable, match="entities"):
        description('<!DOCTYPE r [<!ENTITY a "b">]><robot/>')


def test_a_record_that_is_no_bisection_is_broken() -> None:
    (good,) = cells(np.array([1, 255, 0, 255, 255], dtype=np.uint8), 2)
    centre, half = good.boxes(np.array([0.0, 0.0]), np.array([1.0, 4.0]))
    assert centre.tolist() == [[0.5, 1.0], [0.25, 3.0], [0.75, 3.0]]
    assert half == pytest.approx(np.array([[0.5, 1.0], [0.25, 1.0], [0.25, 1.0]]), rel=1e-12)
    for record in ([1, 255], [255, 255], [2, 255, 255]):
        with pytest.raises(Broken):
            list(cells(np.array(record, dtype=np.uint8), 2))
