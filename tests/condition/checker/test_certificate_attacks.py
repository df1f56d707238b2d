"""Certificates that a burglar made from nothing: each once was 'valid' and false, or brought the checker down."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from asmc_pin.condition.certificate.container import FORMAT, digest, numbers
from asmc_pin.condition.checker import CheckResult, check, replay
from asmc_pin.condition.checker.reading.header_parts import Load
from asmc_pin.condition.checker.reading.link_chain import chain_of
from asmc_pin.condition.checker.reading.urdf_text import Unreadable, description

LIMIT = '<limit lower="-1" upper="1" effort="1" velocity="1"/>'


def urdf(mass: str = '<mass value="1"/>', axis: str = '<axis xyz="1 0 0"/>', extra: str = "", origin: str = "") -> str:
    """Two joints; the norm of M̄ = (1, 1) is 0.5 everywhere."""
    tensor = '<inertia ixx="1" iyy="{}" izz="1" ixy="0" ixz="0" iyz="0"/>'
    return (
        '<robot name="r" xmlns:x="x"><link name="b"/>'
        f'<link name="l1"><inertial>{mass}{tensor.format(1)}</inertial></link>'
        f'<link name="l2"><inertial>{origin}<mass value="1"/>{tensor.format(0.5)}</inertial></link>{extra}'
        f'<joint name="j1" type="revolute"><parent link="b"/><child link="l1"/><axis xyz="0 0 1"/>{LIMIT}</joint>'
        '<joint name="j2" type="revolute"><parent link="l1"/><child link="l2"/><origin xyz="0.1 0 0"/>'
        f"{axis}{LIMIT}</joint></robot>"
    )


def case(
    text: str,
    box: tuple[Sequence[float], Sequence[float]] = ((-1, -1), (1, 1)),
    payload: Mapping[str, Any] | None = None,
    armature: tuple[Sequence[float], Sequence[float]] = ((0, 0), (0, 0)),
) -> dict[str, Any]:
    """A case whose samples fit what the checker reads."""
    load = None if payload is None else Load.model_construct(**payload)
    try:
        chain = chain_of(description(text), ("j1", "j2"), {}, load)
        mass = chain.mass_matrix(np.array([box[0]], dtype=float), np.zeros(2))
    except Unreadable:
        mass = np.eye(2)[None]
    return {
        "label": "whatever",
        "locked": {},
        "payload": payload and {k: v if k == "link" else numbers(np.array(v, dtype=float)) for k, v in payload.items()},
        "lower": numbers(np.array(box[0], dtype=float)),
        "upper": numbers(np.array(box[1], dtype=float)),
        "armature_lower": numbers(np.array(armature[0], dtype=float)),
        "armature_upper": numbers(np.array(armature[1], dtype=float)),
        "sample_q": numbers(np.array([box[0]], dtype=float)),
        "sample_mass": numbers(mass),
    }


def statement(kind: str = "weighted", scale: float = 1.5, level: float = 1.0, **more: Any) -> dict[str, Any]:
    nothing = numbers(np.zeros(2))
    return {"kind": kind, "scale": scale, "level": level, "case": 0, "armature": nothing, "slack": nothing, **more}


def header(text: str, cases: Any, statements: Any, mbar: Any = (1.0, 1.0), **more: Any) -> dict[str, Any]:
    seen = {"case": 0, "q": numbers(np.zeros(2)), "armature": numbers(np.zeros(2))}
    return {
        "format": FORMAT,
        "arm": "ur5",
        "source": "ur5.urdf",
        "sha256": "0",
        "urdf_sha256": hashlib.sha256(text.encode()).hexdigest(),
        "joints": ["j1", "j2"],
        "condition": "weighted",
        "mbar": numbers(np.array(mbar, dtype=float)),
        "verdict": "holds",
        "level": 1.0,
        "upper": None,
        "scale_proven": 0.0,
        "scale_refuted": 1e6,
        "lower": 0.502487562,
        "worst": seen,
        "refuted": seen,
        "cases": cases,
        "statements": statements,
        **more,
    }


def written(path: Path, head: dict[str, Any], text: str, count: int | None = None, spaces: str = "") -> Path:
    records = [np.array([255], dtype=np.uint8)] * (len(head["statements"]) if count is None else count)
    head = {**head, "digest": digest(head, text, records)}
    content = {f"record_{k}": record for k, record in enumerate(records)}
    content["header"] = np.frombuffer((spaces + json.dumps(head)).encode(), dtype=np.uint8)
    content["urdf"] = np.frombuffer(text.encode(), dtype=np.uint8)
    with path.open("wb") as file:
        np.savez_compressed(file, allow_pickle=False, **content)
    return path


def forged(path: Path, text: str, *, cases: Any = None, statements: Any = None, **more: Any) -> CheckResult:
    head = header(text, cases or [case(text)], statements or [statement()], **more)
    return check(written(path, head, text))


def test_the_forgers_own_tools_make_a_valid_certificate(tmp_path: Path) -> None:
    found = forged(tmp_path / "ok.cert", urdf())
    assert found.valid, found.problems
    assert found.hypotheses is not None
    assert found.hypotheses.arm == "r"


MEANT_OTHERWISE: dict[str, str] = {
    "an axis without numbers": urdf(axis="<axis/>"),
    "an axis too short for a float": urdf(axis='<axis xyz="1e-200 0 0"/>'),
    "an inertial without a mass": urdf(mass=""),
    "a mass without a value": urdf(mass="<mass/>"),
    "a mass with blanks": urdf(mass='<mass value=" 1 "/>'),
    "a mass that is no float": urdf(mass='<mass value="2.5e-324"/>'),
    "a rotation by a quaternion": urdf(origin='<origin xyz="0 0 0" quat_xyzw="0 .6 0 .8"/>'),
    "a line break between numbers": urdf(axis='<axis xyz="1&#10;0 0"/>'),
    "two inertials": urdf().replace("</inertial></link>", "</inertial><inertial/></link>", 1),
    "another root": urdf().replace("<robot ", "<model ").replace("</robot>", "</model>"),
    "another version": urdf().replace("<robot ", '<robot version="2.0" '),
    "a revolute joint without limits": urdf().replace(LIMIT, ""),
    "a joint that follows another": urdf().replace(LIMIT, LIMIT + '<mimic joint="j1"/>'),
    "a document type": "<!DOCTYPE robot>" + urdf(),
    "two roots": urdf(extra='<link name="other"/>'),
    "a link that two joints carry": urdf().replace(
        "</robot>", '<joint name="f" type="fixed"><parent link="b"/><child link="l2"/></joint></robot>'
    ),
}


@pytest.mark.parametrize("what", MEANT_OTHERWISE)
def test_a_text_that_readers_take_differently_is_refused(what: str, tmp_path: Path) -> None:
    text = MEANT_OTHERWISE[what]
    with pytest.raises(Unreadable):
        description(text) if "follows" not in what else chain_of(description(text), ("j1", "j2"), {}, None)
    assert not forged(tmp_path / "text.cert", text).valid


@pytest.mark.parametrize(
    "text",
    [
        urdf(extra='<x:link name="l3"/><x:joint name="f" type="fixed"><parent link="l2"/><child link="l3"/></x:joint>'),
        urdf(axis='<x:axis xyz="0 1 0"/><axis xyz="1 0 0"/>'),
        urdf(origin='<x:origin xyz="5 0 0"/>'),
    ],
    ids=["link", "axis", "origin"],
)
def test_an_element_with_a_prefix_is_another_element(text: str) -> None:
    def mass(of: str) -> Any:
        return chain_of(description(of), ("j1", "j2"), {}, None).mass_matrix(np.array([0.3, 0.7]), np.zeros(2))

    assert mass(text) == pytest.approx(mass(urdf()), rel=1e-15)


def test_numbers_that_cancel_leave_the_arm_exact() -> None:
    far = '<origin xyz="{}101700000 0 0"/>'
    text = urdf(
        extra='<link name="l3"><inertial>'
        + far.format("")
        + '<mass value="1"/><inertia ixx="1" iyy="0.2" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>'
    ).replace(
        "</robot>",
        '<joint name="f" type="fixed"><parent link="l2"/><child link="l3"/>' + far.format("-") + "</joint></robot>",
    )
    inertia = chain_of(description(text), ("j1", "j2"), {}, None).inertia[1]
    assert np.diag(inertia)[:3] == pytest.approx([2.0, 0.7, 2.0], rel=1e-15)


def _slack(**more: Any) -> dict[str, Any]:
    return statement(**{k: numbers(np.array(v, dtype=float)) if not np.isscalar(v) else v for k, v in more.items()})


HEAVY = {"mass": 1.0, "com": (0, 0, 0), "inertia": (2.0, 0, 0, 2.0, 0, 2.0), "link": "l2"}
ONE = {"case": 0}, {"case": 1}

FALSE: dict[str, Callable[[], dict[str, Any]]] = {
    "angles where floats lie far apart": lambda: {"cases": [case(urdf(), ((-1, 1e16 + 14), (1, 1e16 + 16)))]},
    "loads at two points": lambda: {
        "cases": [
            case(urdf(), payload={"mass": 0.5, "com": (0, 0, 0), "inertia": (0,) * 6, "link": "l1"}),
            case(urdf(), payload=HEAVY),
        ],
        "statements": [statement(scale=1.0, **one) for one in ONE],
    },
    "a load that no body is": lambda: {
        "cases": [case(urdf(), payload={**HEAVY, "inertia": (-0.9, 0, 0, -0.4, 0, -0.9)})]
    },
    "a load without mass that turns": lambda: {"cases": [case(urdf(), payload={**HEAVY, "mass": 0.0})]},
    "a proof of another armature": lambda: {"statements": [statement(), _slack(armature=(48.0, 49.0), scale=50.0)]},
    "slack below nothing": lambda: {"statements": [statement(), _slack(kind="bounded", level=0.1, slack=(-5.0, -5.0))]},
    "a case left out": lambda: {
        "cases": [case(urdf()), case(urdf(), ((-0.5, -0.5), (0.5, 0.5)), HEAVY)],
        "statements": [statement(scale=1.0, **one) for one in ONE],
    },
    "the same case twice": lambda: {
        "cases": [case(urdf())] * 2,
        "statements": [statement(**one) for one in ONE],
    },
    "a proof of one case only": lambda: {"cases": [case(urdf()), case(urdf(), payload=HEAVY)]},
    "one scale proven and refuted": lambda: {"scale_refuted": 1.2, "scale_proven": 1.5},
}


@pytest.mark.parametrize("what", FALSE)
def test_a_forgery_is_refused(what: str, tmp_path: Path) -> None:
    found = forged(tmp_path / "false.cert", urdf(), **FALSE[what]())
    assert not found.valid
    assert found.to_json_dict()["verdict"] is None


@pytest.mark.parametrize(
    "statements", [[{}] * 200_000, [[]] * 200_000, [{"kind": "weighted", "extra": [0] * 30}] * 9000]
)
def test_many_bad_items_cost_one_message(statements: list[Any], tmp_path: Path) -> None:
    head = header(urdf(), [case(urdf())], statements)
    found = check(written(tmp_path / "many.cert", head, urdf(), count=1))
    assert not found.valid
    assert len(found.problems) == 1


def test_deep_and_huge_numbers_are_answered(tmp_path: Path) -> None:
    deep: Any = []
    for _ in range(800):
        deep = [deep]
    for change in ({"joints": deep}, {"mbar": ["0x1.0000000000000p+9999"] * 2}, {"level": 10**400}):
        head = header(urdf(), [case(urdf())], [statement()]) | change
        assert not check(written(tmp_path / "odd.cert", head, urdf())).valid


def test_cases_that_would_multiply_are_counted_first(tmp_path: Path) -> None:
    cases = [case(urdf(), ((-1, -1), (1, 1 + 1e-6 * k)), {**HEAVY, "mass": 1.0 + k}) for k in range(300)]
    found = forged(tmp_path / "many.cert", urdf(), cases=cases)
    assert not found.valid


def test_links_are_counted_over_all_different_arms_together(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    loads = [None, HEAVY, {**HEAVY, "mass": 2.0}]
    cases = [case(urdf(), ((-1, -1), (1, upper)), load) for load in loads for upper in (1, 2)]
    # Three arms of three links, each with two boxes.
    for most, too_many in ((9, False), (8, True), (3, True)):
        monkeypatch.setattr(replay, "_MOST_BODIES", most)
        found = forged(tmp_path / "arms.cert", urdf(), cases=cases)
        assert any(f"more than {most} links together" in problem for problem in found.problems) is too_many


def test_a_box_with_too_many_corners_is_refused_and_not_laid_out(tmp_path: Path) -> None:
    joints = [f"j{i}" for i in range(24)]
    parts = ['<link name="l-1"/>']
    for i, name in enumerate(joints):
        parts.append(
            f'<link name="l{i}"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>'
            f'</inertial></link><joint name="{name}" type="prismatic"><parent link="l{i - 1}"/><child link="l{i}"/>'
            f'<axis xyz="{int(i % 2 == 0)} {int(i % 2)} 0"/>{LIMIT}</joint>'
        )
    text = f'<robot name="slides">{"".join(parts)}</robot>'
    n = len(joints)
    mass = chain_of(description(text), joints, {}, None).mass_matrix(np.zeros((1, n)), np.zeros(n))
    row = numbers(np.zeros(n))
    big = {
        **case(urdf()),
        "lower": numbers(np.full(n, -3.0)),
        "upper": numbers(np.full(n, 3.0)),
        "armature_lower": row,
        "armature_upper": row,
        "sample_q": numbers(np.zeros((1, n))),
        "sample_mass": numbers(mass),
    }
    seen = {"case": 0, "q": row, "armature": row}
    mbar = np.full(n, 0.01)
    values = np.linalg.eigvalsh(np.linalg.inv(mass[0])) * 0.01
    head = header(text, [big], [statement(scale=1.0, armature=row, slack=row)], mbar=mbar) | {
        "joints": joints,
        "worst": seen,
        "refuted": seen,
        "lower": float(np.abs(1.0 - values).max()),
    }
    found = check(written(tmp_path / "slides.cert", head, text))
    assert not found.valid
    assert any("corners" in problem for problem in found.problems)
