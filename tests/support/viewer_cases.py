"""A result that is quick to make and awkward to show: markup in its labels, and a law that diverges."""

from __future__ import annotations

import atexit
import shutil
import tempfile
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from asmc_pin import compare
from asmc_pin.arms import load_arm
from asmc_pin.experiment import Experiment
from asmc_pin.results.result_folder import Result, load_result
from asmc_pin.viewer import PlayedMotion, TimeMark, describe, draw

HOSTILE = '</script><script>alert(1)</script> & "Proposed"'

AWKWARD: dict[str, Any] = {
    "name": "awkward",
    "arm": "two_link",
    "period": 0.002,
    "duration": 0.4,
    "ensemble": {"trials": 1},
    "reference": {
        "kind": "multisine",
        "offset": [0.3, 0.2],
        "amplitude": [[0.6], [0.6]],
        "frequency": [[1.0], [1.5]],
    },
    "defaults": {"mbar": 0.01, "ks": 5.0, "beta": 5.0},
    "controllers": {HOSTILE: {"law": "ppc"}, "Wild": {"law": "ppc", "beta": 900.0, "ks": 900.0}},
}


INERTIAL = '<inertial><mass value="1"/><inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial>'
BENT = f"""<robot name="bent">
  <link name="base"/>
  <joint name="j1" type="revolute"><parent link="base"/><child link="upper"/><origin xyz="0 0 0.3"/><axis xyz="0 1 0"/>
    <limit lower="-2" upper="2" effort="10" velocity="2"/></joint>
  <link name="upper">{INERTIAL}{{upper}}</link>
  <joint name="j2" type="prismatic"><parent link="upper"/><child link="lower"/><origin xyz="0.4 0 0"/>
    <axis xyz="1 0 0"/>
    <limit lower="0" upper="0.2" effort="10" velocity="2"/></joint>
  <link name="lower">{INERTIAL}{{lower}}</link>
</robot>"""


def bent_arm(folder: Path, upper: str = "", lower: str = "") -> Path:
    """A URDF with a turning and a sliding joint; without visuals unless they are given."""
    path = folder / "bent.urdf"
    path.write_text(BENT.format(upper=upper, lower=lower))
    return path


@cache
def awkward_result() -> Result:
    """The result of the comparison above, made once for all tests of a process."""
    folder = Path(tempfile.mkdtemp(prefix="asmc-awkward-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return load_result(compare(Experiment.from_dict(AWKWARD), out=folder / "awkward").out)


def swung(arm: str, time: Any) -> Any:
    """The reference of `swing`: joint positions at one or several instants."""
    loaded = load_arm(arm)
    wave = 0.6 * np.sin(np.asarray(time)[..., None] * (1.0 + 0.3 * np.arange(loaded.nv)))
    return np.clip(0.0, *loaded.box) + wave


def swing(arm: str = "ur5", *, triangles: int = 4000, duration: float = 2.0) -> dict[str, Any]:
    """Two motions of an arm about one reference, described for the player; the second breaks off at half time."""
    loaded = load_arm(arm)
    time = np.linspace(0.0, duration, 401)
    joint = np.arange(loaded.nv)
    reference = swung(arm, time)
    near, far = reference + 0.01 * np.sin(5.0 * time[:, None] + joint), reference + 0.05 * np.sin(time[:, None])
    far[201:] = np.nan
    share = np.clip(1.5 * np.sin(np.pi * time / duration)[:, None] * np.cos(np.arange(loaded.nv)), -1.0, 1.0)
    motions = [
        PlayedMotion(HOSTILE, "#0072B2", near, torque=share),
        PlayedMotion("Wild", "#CC79A7", far, end=duration / 2),
    ]
    marks = [
        TimeMark(0.25 * duration, 0.5 * duration, "push", HOSTILE),
        TimeMark(0.7 * duration, None, "place", "bend"),
    ]
    return describe(draw(loaded, triangles), loaded.joint_names, time, motions, reference, marks=marks)
