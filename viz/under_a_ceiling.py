"""A UR5 mounted under a ceiling: gravity is given in the base's frame, and the viewer hangs the arm by it.

python viz/under_a_ceiling.py [FOLDER]        default: results/gallery
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from asked import asked_folder
from every_arm import wave

from asmc_pin.arms import load_arm
from asmc_pin.disk.files import write_whole
from asmc_pin.viewer import PlayedMotion, describe, draw, replay_element, replay_page


def make(folder: Path) -> dict[str, Path]:
    """Writes the page; its title and file."""
    arm = load_arm("ur5", gravity=[0.0, 0.0, 9.81])
    time = np.linspace(0.0, 8.0, 481)
    motion = PlayedMotion("under a ceiling", "#D55E00", wave(arm, time))
    drawn = draw(arm)
    element = replay_element(describe(drawn, arm.joint_names, time, [motion], None), drawn.notes)
    page = folder / "under_a_ceiling.html"
    write_whole(page, replay_page("ur5 under a ceiling", "gravity = (0, 0, 9.81) m/s² in the base's frame", element))
    return {"ur5 under a ceiling": page}


if __name__ == "__main__":
    for made in make(asked_folder(__doc__)[0]).values():
        print(made)
