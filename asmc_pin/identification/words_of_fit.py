"""Words about a fit: what was given up, what lies on a bound, and what of a torque each group of estimates explains."""

from __future__ import annotations

import numpy as np

from asmc_pin._typing import Array, BoolArray
from asmc_pin.arms import Arm
from asmc_pin.identification.excitation import Confusion
from asmc_pin.identification.possible_body import LastBody
from asmc_pin.identification.torque_model import PAYLOAD
from asmc_pin.identification.weighted_fit import Fit

_GROUPS = {
    "friction": ("coulomb", "viscous", "weakening"),
    "offset": ("torque_offset",),
    "armature": ("armature",),
    "payload": ("payload.mass", "payload.moment.x", "payload.moment.y", "payload.moment.z"),
    "torque constant": ("torque_constant",),
    "delay": ("delay",),
}


def without_each(fit: Fit) -> dict[str, Array]:
    """RMS of each joint's residual where one group of estimates is taken back to the URDF's, the others kept; (nv,)."""
    start, found = fit.model.start(), {}
    for group, kinds in _GROUPS.items():
        own = np.array([name.split(":")[0] in kinds for name in fit.model.names]) & fit.free
        if own.any():
            residual, _ = fit.model.residual(np.where(own, start, fit.values))
            found[group] = rms_of(residual, fit.rows)
    return found


def on_the_last_joint(arm: Arm) -> dict[str, float]:
    """Links that the last joint moves, and their masses, kg."""
    last = arm.model.njoints - 1
    inertials = arm.made_of.robot.inertials
    links = [frame.name for frame in arm.model.frames if frame.parentJoint == last and frame.name in inertials]
    return {str(link): float(inertials[link].mass) for link in dict.fromkeys(links) if inertials[link].mass > 0.0}


def given_up(each: Confusion) -> str:
    """Why a parameter was not estimated."""
    name = dotted(each.name)
    if each.others:
        return f"{name} was not estimated: this log cannot tell it from {', '.join(map(dotted, each.others))}"
    if each.name.startswith("torque_constant"):
        return f"{name} was taken as 1: this log tells it too badly"
    return f"{name} was not estimated: it makes no torque in this log, and stays as the arm was loaded with it"


def on_the_bound(fit: Fit) -> str:
    """What the log asked for beyond physics, and what became of it."""
    model, wanted = fit.model, fit.impossible
    assert wanted is not None
    mass, *moment = (float(wanted[model.index(name)]) for name in PAYLOAD)
    return (
        f"the log alone asks for a payload of {mass:.3g} kg with the moment ({', '.join(f'{x:.3g}' for x in moment)}) "
        f"kg·m, which the last body, of {LastBody.of(model.arm).mass:.3g} kg, cannot give away: its pseudo-inertia "
        "would have a negative eigenvalue. All estimates are those of the best possible body, which lies on the bound; "
        "intervals are as wide as without it, and that of the mass ends where nothing would be left"
    )


def dotted(name: str) -> str:
    """A parameter's name as a user reads it."""
    return name.replace(":", ".")


def rms_of(residual: Array, rows: BoolArray) -> Array:
    """RMS of a residual over the rows that count, each joint's, (nv,); NaN where none does."""
    masked = np.where(rows, residual, np.nan)
    with np.errstate(invalid="ignore"):
        return np.asarray(np.sqrt(np.nanmean(masked**2, axis=0)))
