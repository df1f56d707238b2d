"""How exactly the tool keeps to its path, whatever its timing: accuracy and repeatability over passes of one motion.

In the manner of ISO 9283:1998, 8.2 (path accuracy, position part) and 8.3 (path repeatability): at points of the
commanded path, the attained paths are cut by the plane that is normal to it, so that a lag along the path is no
error. No conformance is claimed: the standard's test path, load, speeds and ten cycles are not asked for.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.arms import Arm
from asmc_pin.arms.frame_kinematics import FrameKinematics
from asmc_pin.engine import Rollout

POINTS = 100
"""Points of the path at which it is judged, equally far from each other along it."""


@dataclass(frozen=True)
class ToolPath:
    """How a frame of the arm keeps to its path in several passes.

    Attributes:
        frame: Name of the frame.
        passes: Number of trials.
        accuracy: Largest distance of the passes' mean from the commanded path, m; +∞ if a pass diverged, NaN where the
            frame does not move.
        repeatability: Largest l̄ + 3 S_l, with l the distance of a pass from the passes' mean, m; +∞ if a pass diverged,
            NaN with fewer than two passes.
    """

    frame: str
    passes: int
    accuracy: float
    repeatability: float


def tool_path(arm: Arm, run: Rollout, tool: str) -> ToolPath:
    """Judge the path of a frame over the trials of a run, each of which is a pass.

    Args:
        arm: The arm.
        run: What happened.
        tool: Name of a link, or of another frame of the URDF.

    Raises:
        ParameterError: there is no such frame, or not every tick of the run is logged.
    """
    kinematics = FrameKinematics(arm, tool, "tool")
    run.need_every_tick("the tool's path is")
    passes = len(run.status)
    if any(status != "ok" for status in run.status):
        return ToolPath(tool, passes, np.inf, np.inf)
    attained = np.stack([kinematics.poses(q)[:, :3, 3] for q in run.q])
    return ToolPath(tool, passes, *path_figures(kinematics.poses(run.q_ref)[:, :3, 3], attained))


def path_figures(commanded: Array, attained: Array, points: int = POINTS) -> tuple[float, float]:
    """Path accuracy AT_p and path repeatability RT_p.

    At point i, x̄_i the mean of the passes and l_ij = ‖x_ij − x̄_i‖: AT_p = max_i ‖x̄_i − x_ci‖ and
    RT_p = max_i (l̄_i + 3 S_i), S_i the standard deviation of l_ij with n − 1.

    Args:
        commanded: Path of the reference, shape (T, 3), m.
        attained: Paths of the passes at the same times, shape (n, T, 3), m.
        points: Number of points i.

    Returns:
        Both, m; NaN where the path has no length, and RT_p also with a single pass.
    """
    steps = np.linalg.norm(np.diff(commanded, axis=0), axis=1)
    length = np.concatenate([[0.0], np.cumsum(steps)])
    if not length[-1] > 0.0:
        return np.nan, np.nan
    wanted = (np.arange(points) + 0.5) / points * length[-1]
    ticks = (
        np.unique(np.clip(np.searchsorted(length, wanted), 1, len(length) - 2)) if len(length) > 2 else np.array([1])
    )
    accuracy, repeatability = 0.0, 0.0
    for tick in ticks:
        along = commanded[min(tick + 1, len(commanded) - 1)] - commanded[tick - 1]
        if not np.any(along):  # it turns round on the spot: there is no plane normal to it
            continue
        found = _crossings(attained, commanded[tick], along, int(tick))
        mean = found.mean(axis=0)
        accuracy = max(accuracy, float(np.linalg.norm(mean - commanded[tick])))
        if len(found) > 1:
            away = np.linalg.norm(found - mean, axis=1)
            repeatability = max(repeatability, float(away.mean() + 3.0 * away.std(ddof=1)))
    return accuracy, repeatability if len(attained) > 1 else np.nan


def _crossings(attained: Array, point: Array, along: Array, tick: int) -> Array:
    """Where each pass goes forwards through a plane, next in time to a tick; shape (n, 3). `along` may have any length.

    A pass that never does counts with where it is at that tick.
    """
    ahead = (attained - point) @ along
    through = (ahead[:, :-1] <= 0.0) & (ahead[:, 1:] > 0.0)
    far = np.where(through, np.abs(np.arange(through.shape[1]) - tick + 0.5), np.inf)
    before = np.argmin(far, axis=1)
    rows = np.arange(len(attained))
    low, high = ahead[rows, before], ahead[rows, before + 1]
    crossed = np.isfinite(far[rows, before])
    part = np.divide(-low, high - low, out=np.zeros(len(rows)), where=crossed)[:, None]
    between = (1.0 - part) * attained[rows, before] + part * attained[rows, before + 1]
    return np.asarray(np.where(crossed[:, None], between, attained[:, tick]))
