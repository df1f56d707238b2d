"""`identify`: from the log of an arm to what its URDF leaves out."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from asmc_pin._typing import Array, BoolArray
from asmc_pin.arms import Arm
from asmc_pin.errors import ParameterError
from asmc_pin.identification.estimates import WIDTH
from asmc_pin.identification.excitation import Confusion, judged
from asmc_pin.identification.filtered_motion import FilteredMotion, filter_log
from asmc_pin.identification.identification_report import Identification, contradicted, identified
from asmc_pin.identification.stribeck_search import stribeck_speeds
from asmc_pin.identification.suspects import suspect
from asmc_pin.identification.torque_model import PAYLOAD, TorqueModel, torque_model
from asmc_pin.identification.weighted_fit import Fit, fit
from asmc_pin.logs.joint_log import JointLog, read_log
from asmc_pin.logs.log_options import LogOptions
from asmc_pin.words.given import check_arm

GROUPS = ("coulomb", "viscous", "stribeck", "armature", "payload", "torque_constant", "torque_offset", "delay")
"""What can be held at the URDF's value by `fix`."""

_BLOCKS = 12  # of a log; every fourth is held out
_REST = 0.02  # rad/s (m/s); slower than that a joint may stick
_UNSURE = 0.3  # half an interval of a torque constant beyond which it is taken as 1


def identify(
    arm: Arm,
    log: str | Path | JointLog,
    *,
    options: LogOptions | None = None,
    cutoff_hz: float | None = None,
    fix: Sequence[str] = (),
) -> Identification:
    """Say how right a URDF is by the log of a real arm, and estimate what it leaves out.

    Signs, order and units of the log's columns and the direction of gravity are tested first. Where they contradict
    the URDF, that is said and nothing is estimated. Three quarters of the log are fitted, in blocks over its length;
    the rest is held out.

    Args:
        arm: As it was loaded, with what is known of it: a payload of its own stays, the estimated one comes on top.
        log: A file as `read_log` takes it, or a log.
        options: How the file is to be read.
        cutoff_hz: Of the angles' low-pass; chosen by the noise of the log when omitted.
        fix: Groups of parameters that are not estimated, of `GROUPS`.

    Returns:
        The identification, with estimates and intervals of 95 %.

    Raises:
        ParameterError: The log cannot be read or has no torque, an unknown group, or a joint that mimics another.
    """
    check_arm(arm)
    for name in fix:
        if name not in GROUPS:
            raise ParameterError("fix", f"'{name}' given; expected some of {', '.join(GROUPS)}")
    if arm.mimics:
        raise ParameterError(
            "arm", "has joints that mimic others, for which there is no regressor; lock those they follow"
        )
    if not isinstance(log, JointLog):
        log = read_log(log, arm.joint_names, options, kinds=arm.joint_kinds)
    motion = filter_log(log, cutoff_hz)
    # A sensor on the links' side does not feel the rotors that the arm was loaded with.
    felt = arm if log.torque_side == "motor" else arm.replace(armature=[0.0] * arm.nv)
    suspicions = suspect(felt, motion, log)
    model = torque_model(felt, motion, _rest(motion))
    if suspicions:
        return contradicted(arm, log, model, suspicions)
    train, held_out = _split(model)
    if min(int(train.sum(axis=0).min()), int(held_out.sum(axis=0).min())) < 20:
        slow = log.joint_names[int(train.sum(axis=0).argmin())]
        raise ParameterError(
            "log", f"{log.name}: joint '{slow}' hardly moves; a log in which every joint swings is needed, or lock it"
        )
    found, condition, confusions = _estimated(model, train, _wanted(model, log, fix), fix)
    return identified(arm, log, found, held_out, condition, confusions)


def _rest(motion: FilteredMotion) -> Array:
    """Speeds at which a joint may stick: as slow as that, or not to be told from it."""
    nv = motion.q.shape[1]
    noise = np.sqrt(2.0 * motion.step * (2.0 * np.pi) ** 2 * motion.cutoff**3 / 3.0) * motion.noise_q
    if motion.from_velocity and motion.noise_v is not None:
        noise = motion.noise_v * np.sqrt(2.0 * motion.step * motion.cutoff)
    return np.asarray(np.maximum(np.full(nv, _REST), 3.0 * noise))


def _split(model: TorqueModel) -> tuple[BoolArray, BoolArray]:
    """Rows to fit and rows held out, with a gap between as long as the filter remembers."""
    time = model.time
    length = (time[-1] - time[0]) / _BLOCKS
    block = np.minimum(((time - time[0]) / length).astype(np.int64), _BLOCKS - 1)
    out = block % 4 == 2
    into = (time - time[0]) - block * length
    edge = (into < 1.0 / model.motion.band) & out
    return model.usable & ~out[:, None], model.usable & (out & ~edge)[:, None]


def _wanted(model: TorqueModel, log: JointLog, fix: Sequence[str]) -> BoolArray:
    kinds = [name.split(":")[0] for name in model.names]
    out = {"weakening", "stribeck_velocity", *fix}
    if "payload" in fix:
        out |= set(PAYLOAD)
    if log.torque_side == "link":
        out.add("armature")
    return np.array([kind not in out for kind in kinds])


def _estimated(
    model: TorqueModel, rows: BoolArray, free: BoolArray, fix: Sequence[str]
) -> tuple[Fit, float, list[Confusion]]:
    start = model.start()
    residual, _ = model.residual(start)
    sigma = np.maximum(np.array([residual[rows[:, j], j].std() for j in range(model.arm.nv)]), 1e-9)
    free, condition, confusions = judged(model, start, sigma, rows, free)
    found = fit(model, rows, free)
    if "stribeck" not in fix:
        found = _with_stribeck(found, rows, free)
    if unsure := _unsure_constants(found):
        free, start = found.free.copy(), found.values.copy()
        for place in unsure:
            free[place], start[place] = False, 1.0
            confusions.append(Confusion(model.names[place], ()))
        found = fit(model, rows, free, start)
    # Judged again where the estimates are.
    _, condition, _ = judged(model, found.values, found.sigma, rows, found.free)
    return found, condition, confusions


def _unsure_constants(found: Fit) -> list[int]:
    """Torque constants that may be anything; judged by the width of the interval alone, whatever the value."""
    names, half = found.model.names, WIDTH * found.deviation
    return [int(i) for i in np.flatnonzero(found.free) if names[i].startswith("torque_constant") and half[i] > _UNSURE]


def _with_stribeck(found: Fit, rows: BoolArray, free: BoolArray) -> Fit:
    """The fit with friction that falls with speed, in the joints in which the log shows it."""
    model = found.model
    speeds, weakening = stribeck_speeds(model, rows, found.values)
    seen = [int(j) for j in np.flatnonzero(np.isfinite(speeds))]
    for _ in range(2):
        if not seen:
            return found
        start, more = found.values.copy(), free.copy()
        for j in seen:
            for kind, value in (("weakening", weakening[j]), ("stribeck_velocity", speeds[j])):
                place = model.index(kind, j)
                more[place], start[place] = True, value
        tried = fit(model, rows, more, start)
        sure = [j for j in seen if _is_sure(tried, j)]
        if len(sure) == len(seen):
            return tried
        seen = sure
    return tried if seen else found


def _is_sure(tried: Fit, joint: int) -> bool:
    place, speed = tried.model.index("weakening", joint), tried.model.index("stribeck_velocity", joint)
    within = tried.values[place] > 3.0 * tried.deviation[place] > 0.0
    return bool(within and tried.deviation[speed] < 0.5 * tried.values[speed])
