"""The replay of a result: every controller's arm side by side, the reference as a ghost in each."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.disk.files import write_whole
from asmc_pin.errors import AsmcPinError, ResultError
from asmc_pin.results.kept_ticks import keeps_the_end
from asmc_pin.viewer.colours import controller_colors
from asmc_pin.viewer.drawing.drawn_bodies import TRIANGLES, draw
from asmc_pin.viewer.played_motion import PlayedMotion, describe
from asmc_pin.viewer.player_page import replay_element, replay_page
from asmc_pin.viewer.time_marks import time_marks

if TYPE_CHECKING:
    from asmc_pin.arms import Arm
    from asmc_pin.results.result_folder import Result


_ALL_TRIANGLES = 240_000
"""Of all arms and ghosts of a page together: of four arms side by side each is a quarter as wide as the screen."""


def replay_html(result: Result, *, trial: int = 0) -> str:
    """A page of its own that replays a result, offline and in any browser with WebGL.

    The same result gives the same text.

    Args:
        result: See `asmc_pin.results.result_folder.load_result`.
        trial: Which trial to show.

    Raises:
        ResultError: The arm cannot be loaded any more, or is another one now; or there is no such trial.
    """
    arm = _arm(result)
    subtitle = f"{arm.name}, {arm.nv} joints, {float(result.dataset.time[-1]):g} s"
    if result.dataset.sizes["trial"] > 1:
        subtitle += f", trial {trial}"
    return replay_page(result.experiment.name, subtitle, replay_fragment(result, trial=trial, embedded=False))


def replay_fragment(result: Result, *, trial: int = 0, embedded: bool = True) -> str:
    """The replay as an element for a longer page, which needs `page.player_scripts` and ``player.css`` once.

    Args:
        result: The result.
        trial: Which trial to show.
        embedded: See `page.replay_element`.

    Raises:
        ResultError: As `replay_html`.
    """
    arm, dataset = _arm(result), result.dataset
    if not 0 <= trial < dataset.sizes["trial"]:
        raise ResultError(
            result.path, f"{result.path} has no trial {trial}; it has {dataset.sizes['trial']}, counted from 0"
        )
    # As many arms as there are controllers, and as many ghosts: what a browser draws stays bounded.
    drawn = draw(arm, min(TRIANGLES, _ALL_TRIANGLES // (2 * dataset.sizes["controller"])))
    notes = list(drawn.notes)
    then = result.provenance.get("arm", {})
    now = {"sha256": arm.sha256, "urdf_sha256": hashlib.sha256(arm.urdf_text.encode()).hexdigest()}
    if any(then.get(key, value) != value for key, value in now.items()):
        notes.append(f"The URDF has changed since the run: {arm.source.name} is drawn as it is now.")
    run = dataset.isel(trial=trial)
    labels = [str(label) for label in run.controller.to_numpy()]
    colours = controller_colors(labels)
    torque = _over_limits(result, trial)
    motions = [
        PlayedMotion(
            label=label,
            colour=colours[label],
            q=run.q.isel(controller=k).transpose("time", "joint").to_numpy(),
            torque=torque[k],
            end=None if str(run.status.to_numpy()[k]) == "ok" else float(run.end_time.to_numpy()[k]),
        )
        for k, label in enumerate(labels)
    ]
    reference = run.q_ref.transpose("time", "joint").to_numpy()
    description: dict[str, Any] = describe(
        drawn, arm.joint_names, run.time.to_numpy(), motions, reference, marks=time_marks(result, trial)
    )
    return replay_element(description, tuple(notes), embedded=embedded)


def write_replay(result: Result, path: str | Path, *, trial: int = 0) -> None:
    """Write `replay_html` to a file.

    Args:
        result: The result.
        path: Where to.
        trial: Which trial to show.

    Raises:
        ResultError: As `replay_html`; or the file cannot be written.
    """
    write_whole(path, replay_html(result, trial=trial))


def _over_limits(result: Result, trial: int) -> Array:
    """Torques over the joints' limits, where there is none over the largest of the run; (controllers, T, nv)."""
    torque = result.dataset.torque.isel(trial=trial).transpose("controller", "time", "joint").to_numpy().copy()
    if keeps_the_end(len(result.experiment.time), result.experiment.log_every):
        torque[:, -1] = 0.0  # that of a period which the run does not have any more
    limits = np.asarray(result.experiment.build_plant().effort_limit, dtype=np.float64)
    limit = limits[min(trial, len(limits) - 1)] if limits.ndim == 2 else limits
    largest = np.max(np.abs(torque), axis=(0, 1), initial=0.0, where=np.isfinite(torque))
    # Without a limit nothing may look as if it stood at one.
    return np.asarray(torque / np.where(np.isfinite(limit), limit, 1.001 * np.maximum(largest, 1e-12)))


def _arm(result: Result) -> Arm:
    try:
        arm = result.experiment.build_arm()
    except AsmcPinError as error:
        raise ResultError(result.path, f"the arm of {result.path} cannot be loaded any more: {error}") from error
    joints = tuple(str(joint) for joint in result.dataset.joint.to_numpy())
    if joints != arm.joint_names:
        raise ResultError(
            result.path,
            f"{result.path} was run on another arm: its joints are {', '.join(joints)}, those of {arm.source} are "
            f"{', '.join(arm.joint_names)}; run the comparison again",
        )
    return arm
