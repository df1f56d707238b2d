"""Logged velocities held against the derivative of the logged angles: what is wrong with their sign, unit or order."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from asmc_pin.identification.filtered_motion import FilteredMotion
from asmc_pin.identification.suspicion import Suspicion
from asmc_pin.logs.joint_log import JointLog
from asmc_pin.words.text import quoted

_VELOCITIES = (0.0, 0.0, ("--columns", "v=-"))  # of a suspicion: no scores, and the angles' derivative does instead


def suspect_velocities(motion: FilteredMotion, log: JointLog) -> Iterator[Suspicion]:
    """Logged velocities against the derivative of the angles: sign, unit and order."""
    if log.v is None or motion.from_velocity:
        own = None if log.v is None else np.gradient(motion.q, motion.step, axis=0)
    else:
        own = motion.v
    if log.v is None or own is None:
        return
    logged = np.column_stack([np.interp(motion.time, log.time, log.v[:, j]) for j in range(log.v.shape[1])])
    for j, name in enumerate(log.joint_names):
        power = float(own[:, j] @ own[:, j])
        slope = float(logged[:, j] @ own[:, j]) / power if power > 0.0 else 1.0
        if power == 0.0 or not np.std(logged[:, j]):
            continue  # it stands still
        with np.errstate(invalid="ignore"):
            match = np.nan_to_num(np.abs(np.corrcoef(logged[:, j], own, rowvar=False)[0, 1:]))
        if match[j] < 0.8 and match.max() > 0.95:
            other = log.joint_names[int(match.argmax())]
            yield Suspicion(
                f"the velocity of joint {quoted(name)} is that of {quoted(other)}: their order is wrong",
                *_VELOCITIES,
            )
        elif match[j] > 0.8 and slope < 0.0:
            yield Suspicion(f"the velocity of joint {quoted(name)} has the opposite sign of its angle", *_VELOCITIES)
        elif match[j] > 0.8 and not 0.8 < slope < 1.25:
            unit = "; it is in degrees/s" if 50.0 < slope < 65.0 else "; angles are in degrees" if slope < 0.02 else ""
            yield Suspicion(
                f"the velocity of joint {quoted(name)} is {slope:.3g} times the derivative of its angle{unit}",
                *_VELOCITIES,
            )
