"""Sixty kinds of URDF: each loads or is refused as it should be, and what is doubtful about it is said, no more."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from arm_urdf import write
from urdf_kinds import KINDS

from asmc_pin import inspect, load_arm
from asmc_pin.errors import ArmError
from asmc_pin.inspection.inspecting import serious_doubts

NEED_A_MESH = {"centre outside"}


def test_there_are_sixty_kinds() -> None:
    assert len(KINDS) >= 60
    assert len({(kind.text, str(kind.options)) for kind in KINDS.values()}) >= 60


@pytest.mark.parametrize("name", KINDS)
def test_a_kind_gives_its_doubts_and_no_others(name: str, tmp_path: Path) -> None:
    kind = KINDS[name]
    path = write(tmp_path, kind.text)
    if kind.unreadable:
        with pytest.raises(ArmError, match=kind.refused):
            inspect(path)
        return
    found = inspect(path, **kind.options)
    assert {doubt.kind for doubt in found.doubts if doubt.serious} == set(kind.doubts)
    assert {doubt.kind for doubt in found.doubts if not doubt.serious} == set(kind.remarks)
    if kind.refused:
        assert kind.refused in found.refusal
        with pytest.raises(ArmError, match=kind.refused):
            load_arm(path, **kind.options)
        return
    assert found.refusal == ""
    arm = load_arm(path, **kind.options)
    assert arm.nv == kind.nv == sum(not joint.follows for joint in found.joints)
    # What a command prints on loading is what the inspection finds without meshes.
    assert {doubt.kind for doubt in serious_doubts(arm)} == set(kind.doubts) - NEED_A_MESH
    lower, upper = arm.box
    assert np.linalg.eigvalsh(arm.mass_matrix(0.5 * (lower + upper)))[0] > 0.0
