"""Every arm known by name, waving: one page each.

python viz/every_arm.py [FOLDER]        default: results/gallery
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from asked import asked_folder

from asmc_pin.arms import ARMS, Arm, arm_names, load_arm
from asmc_pin.disk.files import write_whole
from asmc_pin.viewer import PlayedMotion, describe, draw, replay_element, replay_page

# Where an arm is good to look at; the middle of the joint box for the others.
POSES = {
    "ur3": [0.0, -1.2, 1.4, -1.6, -1.5, 0.0],
    "ur5": [0.0, -1.2, 1.4, -1.6, -1.5, 0.0],
    "ur10": [0.0, -1.2, 1.4, -1.6, -1.5, 0.0],
    "panda": [0.0, -0.4, 0.0, -2.0, 0.0, 1.7, 0.7],
    "kinova": [0.0, 2.6, 1.3, 0.0, 1.0, 0.0],
    "xarm7": [0.0, -0.4, 0.0, 1.0, 0.0, 1.3, 0.0],
    "z1": [0.0, 1.2, -1.2, 0.1, 0.0, 0.0],
    "two_link": [0.5, 0.6],
    "double_pendulum": [0.4, 0.4],
}


def wave(arm: Arm, time: np.ndarray) -> np.ndarray:
    """Each joint swings about its pose, the outer ones faster; shape (T, nv), rad or m."""
    lower, upper = arm.box
    middle = np.array(POSES.get(arm.name, (lower + upper) / 2))
    room = np.minimum(0.4, 0.8 * np.minimum(upper - middle, middle - lower))
    return middle + room * np.sin(2 * np.pi * time[:, None] * (1 + np.arange(arm.nv)) / time[-1])


def page(arm: Arm, title: str, subtitle: str) -> str:
    """HTML of an arm that waves for 8 s."""
    time = np.linspace(0.0, 8.0, 481)
    drawn = draw(arm)
    description = describe(drawn, arm.joint_names, time, [PlayedMotion(title, "#0072B2", wave(arm, time))], None)
    return replay_page(title, subtitle, replay_element(description, drawn.notes))


def make(folder: Path) -> dict[str, Path]:
    """Writes the pages; their titles and files."""
    pages = {name: folder / f"arm_{name}.html" for name in arm_names()}
    for name, file in pages.items():
        write_whole(file, page(load_arm(name), name, ARMS[name].description))
    return pages


if __name__ == "__main__":
    for made in make(asked_folder(__doc__)[0]).values():
        print(made)
