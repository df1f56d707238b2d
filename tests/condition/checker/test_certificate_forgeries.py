"""A certificate that a stranger made: whatever is changed in it, what the check says of it is true, or it says no.

Every field of valid certificates is mutated, removed and exchanged between certificates, and the digest made to fit. A
change may leave a file valid: then what is printed has to be true of the arm that is inside, which Pinocchio judges.
"""

from __future__ import annotations

import copy
import json
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from arm_urdf import write
from certificate_cases import blocks
from certificate_truth import untruths
from condition_cases import chain
from coupled_urdf import gripper

from asmc_pin import BoundsReport, LoopProof, SampledLoop, bounds, certify_loop, load_arm
from asmc_pin.arms import Arm, Payload
from asmc_pin.condition.certificate import CertificateResult, certify
from asmc_pin.condition.certificate.container import Container, digest, read
from asmc_pin.condition.checker import check
from asmc_pin.errors import ResultError
from asmc_pin.experiment import load_experiment

pytestmark = pytest.mark.xdist_group("test_certificate_forgeries")  # they share what `cache` keeps

SHARES = 40
"""The mutations are dealt into so many hands, of which the quick suite plays one, `make test-all` a third
and `make soundness` all."""

KINDS = ("level", "ranges", "payload", "locks", "violated", "tube", "asked", "bounds", "loop", "unstable", "mimic")
LOAD = Payload(0.5, com=(0.02, 0.0, 0.05), inertia=(0.01, 0.001, 0.0, 0.02, 0.0, 0.015))


def _mbar(arm: Arm, share: float) -> Any:
    q = np.random.default_rng(0).uniform(*arm.box, (400, arm.nv))
    return np.full(arm.nv, share * np.linalg.eigvalsh(arm.mass_matrix(q)).min())


def _made(kind: str, folder: Path) -> CertificateResult | BoundsReport | LoopProof:
    arm = load_arm("two_link")
    quick: dict[str, Any] = {"gap": 0.3, "budget": 5.0}
    if kind == "level":
        return certify(arm, 0.01, condition="lemma1", **quick)
    if kind == "ranges":
        return certify(arm, _mbar(arm, 1.0), condition="weighted", armature=[(0.01, 0.02), (0.0, 0.01)], **quick)
    if kind == "payload":
        ends = (Payload(0.0, com=LOAD.com), LOAD)
        return certify(arm, 0.01, condition="lemma1", payload=ends, armature=[(0.0, 0.01), (0.01, 0.03)], **quick)
    if kind == "locks":
        sliding = chain(folder, 4, 3, prismatic=True).replace(payload=LOAD)
        return certify(sliding, _mbar(sliding, 0.4)[:2], condition="weighted", lock={"j2": (0.1, 0.5)}, **quick)
    if kind == "violated":
        return certify(load_arm("double_pendulum"), 5.0, condition="weighted", gap=0.5, budget=1e-4)
    if kind == "bounds":
        return bounds(arm, scaling=[1.0, 2.5], payload=(0.0, 0.4), armature=[(0.01, 0.02), (0.0, 0.01)], gap=0.05)
    if kind == "mimic":
        coupled = load_arm(write(folder, gripper(), "mimic.urdf"), armature=0.02)
        return certify(coupled, _mbar(coupled, 1.0), condition="weighted", **quick)
    if kind in ("loop", "unstable"):
        gain = 20.0 if kind == "loop" else 200.0
        return certify_loop(arm, SampledLoop(np.full(2, 0.03), gain, gain, 1e-3), armature=[(0.01, 0.02), (0.0, 0.0)])
    if kind == "tube":
        along = load_experiment("baek2016_simulation_smooth")
        return certify(arm, 0.01, condition="lemma1", along=along, tube_width=0.02, slices=3, **quick)
    return certify(arm, 0.01, condition="lemma1", level=0.995, **quick)


@cache
def _certificates(folder: Path) -> dict[str, Container]:
    found = {}
    for kind in KINDS:
        path = _made(kind, folder).save(folder / f"{kind}.cert")
        replayed = check(path)
        assert replayed.valid, (kind, replayed.problems)
        assert untruths(path, replayed.to_json_dict(), folder) == []
        found[kind] = read(path)
    return found


@pytest.fixture(scope="module")
def certificates(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Container]:
    return _certificates(tmp_path_factory.mktemp("certificates"))


def _paths(value: Any, at: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Every place in the header, those inside of lists and objects too."""
    if at:
        yield at
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, item in items:
        yield from _paths(item, (*at, key))


def _parent(header: Any, at: tuple[Any, ...]) -> Any:
    for key in at[:-1]:
        header = header[key]
    return header


def _number(value: float) -> list[float]:
    return [value * 1.01 + 1e-3, value * 0.99 - 1e-3, value * 1e3, -value, 0.0, 1.0, value + 1e-7, 1e300]


def _others(value: Any) -> list[Any]:
    """What may stand in the place of a value."""
    if isinstance(value, bool) or value is None:
        return [0.5, {}, "x"]
    if isinstance(value, int):
        return [value + 1, -1, 10**9, 0.5, None]
    if isinstance(value, float):
        return [*_number(value), float("nan"), float("inf"), -float("inf"), None, str(value)]
    if isinstance(value, str):
        try:
            number = float.fromhex(value)
        except (ValueError, OverflowError):
            kinds = ("weighted", "bounded", "lemma1", "level", "holds", "violated", "undecided", "", "x\x1b[2J")
            return [kind for kind in kinds if kind != value]
        return [*(x.hex() for x in _number(number)), "nan", "inf", "0x1p99999", number, "1.5"]
    if isinstance(value, list):
        return [value[:-1], [*value, *value[-1:]], value[::-1], [], [value], None]
    return [{}, {**value, "extra": 1}, [], None]


def _mutants(certificates: dict[str, Container]) -> Iterator[tuple[str, Container]]:
    for kind, container in certificates.items():
        for path in _paths(container.header):
            own = _parent(container.header, path)[path[-1]]
            for other in _others(own):
                yield f"{kind} {path} = {str(other)[:60]}", _with(container, path, other)
            if isinstance(_parent(container.header, path), dict):
                removed = copy.deepcopy(container.header)
                del _parent(removed, path)[path[-1]]
                yield f"{kind} {path} removed", Container(removed, container.urdf, container.records)
            for theirs, other_container in certificates.items():
                try:
                    value = _parent(other_container.header, path)[path[-1]]
                except (KeyError, IndexError, TypeError):
                    continue
                if theirs != kind and value != own:
                    yield f"{kind} {path} of {theirs}", _with(container, path, value)
        for theirs, other_container in certificates.items():
            yield (
                f"{kind} with the URDF of {theirs}",
                Container(
                    {**container.header, "urdf_sha256": other_container.header["urdf_sha256"]},
                    other_container.urdf,
                    container.records,
                ),
            )
            yield (
                f"{kind} with the proofs of {theirs}",
                Container(container.header, container.urdf, other_container.records),
            )


def _with(container: Container, path: tuple[Any, ...], value: Any) -> Container:
    header = copy.deepcopy(container.header)
    _parent(header, path)[path[-1]] = value
    return Container(header, container.urdf, container.records)


def _written(container: Container, path: Path) -> Path:
    header = dict(container.header)
    if "digest" in header:
        header["digest"] = digest(header, container.urdf, container.records)
    content = {f"record_{k}": record for k, record in enumerate(container.records)}
    content["header"] = np.frombuffer(json.dumps(header).encode(), dtype=np.uint8)
    content["urdf"] = np.frombuffer(container.urdf.encode(), dtype=np.uint8)
    with path.open("wb") as file:
        np.savez(file, allow_pickle=False, **content)
    return path


def _play(certificates: dict[str, Container], hand: range | None, folder: Path) -> tuple[int, int]:
    """Check the mutants of some hands; how many there were, and how many stayed valid with nothing false said."""
    count = valid = 0
    for number, (what, container) in enumerate(_mutants(certificates)):
        if hand is not None and number % SHARES not in hand:
            continue
        count += 1
        path = _written(container, folder / "mutant.cert")
        try:
            found = check(path)
        except ResultError:
            # A header without its format is no certificate; all else is answered by the check.
            if "format" not in what:
                raise
            continue
        said = json.loads(json.dumps(found.to_json_dict(), allow_nan=False))
        if found.valid:
            valid += 1
            assert untruths(path, said, folder) == [], what
        else:
            assert found.problems, what
            assert said["verdict"] is None, what
            assert all(problem.isprintable() for problem in found.problems), what
    return count, valid


def test_a_mutated_certificate_is_refused_or_true(certificates: dict[str, Container], tmp_path: Path) -> None:
    count, valid = _play(certificates, range(1), tmp_path)
    assert count > 150
    assert valid < 0.5 * count


@pytest.mark.soundness
@pytest.mark.parametrize("hand", blocks(range(1, SHARES)))
def test_every_field_mutated_is_refused_or_true(hand: int, certificates: dict[str, Container], tmp_path: Path) -> None:
    _play(certificates, range(hand, hand + 1), tmp_path)
