"""How far the tool is from where the reference would have it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.arms import Arm
from asmc_pin.arms.frame_kinematics import FrameKinematics
from asmc_pin.engine import Rollout


@dataclass(frozen=True, eq=False)
class ToolError:
    """Distance between a frame of the arm and the same frame of the reference.

    Attributes:
        frame: Name of the frame.
        position: Distance of the origins at each tick, shape (batch, T), m; NaN once a trial has diverged.
        rotation: Angle of the turn between the two, shape (batch, T), rad, 0 to π.
    """

    frame: str
    position: Array
    rotation: Array

    def figures(self) -> dict[str, Array]:
        """RMS and maximum of both over the run, each (batch,); NaN for a trial that diverged. m and rad."""
        return {
            f"{name}_{what}": np.asarray(figure)
            for what, error in (("position", self.position), ("rotation", self.rotation))
            for name, figure in (("rms", np.sqrt(np.mean(error**2, axis=1))), ("max", np.max(error, axis=1)))
        }


def tool_error(arm: Arm, run: Rollout, tool: str) -> ToolError:
    """Compare where the tool is with where it would be on the reference.

    Args:
        arm: The arm.
        run: What happened.
        tool: Name of a link, or of another frame of the URDF.

    Raises:
        ParameterError: there is no such frame, or not every tick of the run is logged.
    """
    kinematics = FrameKinematics(arm, tool, "tool")
    run.need_every_tick("the tool's error is")
    wanted, found = kinematics.poses(run.q_ref), kinematics.poses(run.q)
    position = np.linalg.norm(found[..., :3, 3] - wanted[..., :3, 3], axis=-1)
    turn = np.einsum("...ji,...jk->...ik", wanted[..., :3, :3], found[..., :3, :3])
    # The sine from the skew part and the cosine from the trace: exact near 0 and near π alike.
    sine = 0.5 * np.linalg.norm(
        np.stack(
            [
                turn[..., 2, 1] - turn[..., 1, 2],
                turn[..., 0, 2] - turn[..., 2, 0],
                turn[..., 1, 0] - turn[..., 0, 1],
            ]
        ),
        axis=0,
    )
    cosine = 0.5 * (np.trace(turn, axis1=-2, axis2=-1) - 1.0)
    return ToolError(tool, position, np.arctan2(sine, cosine))
