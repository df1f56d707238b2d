"""What an M̄ would have done along a log: its TDE error and Lemma 1's norm, for the arm as it was measured."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline

from asmc_pin._typing import Array
from asmc_pin.condition import ConditionReport, Recording, verify
from asmc_pin.condition.norm.two_conditions import check_mbar
from asmc_pin.errors import ParameterError
from asmc_pin.identification.identification_report import Identification
from asmc_pin.identification.measured_load import measured_arm
from asmc_pin.logs.resampling import low_passed
from asmc_pin.words.joint_units import column_cells, column_head
from asmc_pin.words.shown import Cells, Shown
from asmc_pin.words.text import printable


@dataclass(frozen=True, eq=False, repr=False)
class MbarAlongLog(Shown):
    """What an M̄ would have done along a log.

    Attributes:
        found: What was identified of the log.
        report: Lemma 1 along the log, for the arm as measured; its `times`, `norms` and `tde_error` are what is drawn.
        recording: Motion and torque that it was computed from, at the ticks of a loop, below `band`.
        period: L, s.
        band: Hz; what is above it in torque and acceleration is not in the error.
        left_out: What of the estimates the arm does not have, a sentence each.
    """

    found: Identification
    report: ConditionReport
    recording: Recording
    period: float
    band: float
    left_out: tuple[str, ...]

    @property
    def error(self) -> Array:
        """The TDE error N = Γ − Γ̂ at all ticks but the first, shape (T − 1, nv), rad/s² (m/s²)."""
        assert self.report.tde_error is not None
        return np.asarray(self.report.tde_error[1:])

    def headline(self) -> str:
        """Whether Lemma 1 held, and where it was nearest to failing or failed furthest."""
        assert self.report.norms is not None
        ticks, held = len(self.report.norms), int(np.sum(self.report.norms < 1.0))
        kept = f"held at each of its {ticks} ticks" if held == ticks else f"held at {held} of its {ticks} ticks"
        return (
            f"M̄ along the log: ‖I − M(q)⁻¹M̄‖ < 1 {kept}; its largest value is {self.report.lower:.4g}, at "
            f"t = {self.report.worst_time:.4g} s"
        )

    def lines(self) -> list[str]:
        """The condition, the error, and what they were computed from."""
        return [
            self.headline(),
            f"TDE error N = Γ − Γ̂ of L = {self.period:.4g} s, from logged accelerations and torques below "
            f"{self.band:g} Hz: no model is in it, and no noise above that",
            *self.left_out,
        ]

    def table(self) -> Cells:
        """M̄, the configuration of the largest norm, and the TDE error, joint by joint."""
        slides = [kind == "prismatic" for kind in self.found.arm.joint_kinds]
        largest, rms = _largest(self.error), _rms(self.error)
        columns = (
            column_cells([f"{m:.4g}" for m in self.report.mbar], "inertia", slides),
            column_cells([f"{q:+.4f}" for q in self.report.worst_q], "place", slides),
            column_cells([f"{x:.3g}" for x in largest], "acceleration", slides),
            column_cells([f"{x:.3g}" for x in rms], "acceleration", slides),
        )
        head = [column_head("m̄", "inertia", slides), column_head("worst q", "place", slides)]
        head += [column_head(name, "acceleration", slides) for name in ("largest |N|", "RMS of N")]
        rows = zip(map(printable, self.found.arm.joint_names), *columns, strict=True)
        return ["joint", *head], [list(row) for row in rows]

    def to_json_dict(self) -> dict[str, Any]:
        """What ``identify --mbar --json`` says under ``mbar``."""
        return {
            "mbar": self.report.mbar.tolist(),
            "period": self.period,
            "band_hz": self.band,
            "norm_largest": self.report.lower,
            "norm_smallest": self.report.smallest,
            "worst_time": self.report.worst_time,
            "worst_q": self.report.worst_q.tolist(),
            "tde_error_max": _largest(self.error).tolist(),
            "tde_error_rms": _rms(self.error).tolist(),
            "left_out": list(self.left_out),
        }


def mbar_on_log(found: Identification, mbar: Any, *, period: float | None = None) -> MbarAlongLog:
    """Say what an M̄ would have done along a log that was identified.

    The condition is that of `asmc_pin.verify` along recorded data, for the arm as measured (payload and armature at
    their values), and the error that of `tde_error` with the log's own accelerations.

    Args:
        found: With estimates.
        mbar: Diagonal of M̄, one value or nv of them, kg·m².
        period: L, s; the median distance of the log's rows when omitted.

    Raises:
        ParameterError: Nothing was estimated, M̄ or L is none, or L is as long as the log.
    """
    if found.fit is None:
        raise ParameterError("mbar", "the log contradicts the URDF, so there is no arm to judge M̄ on; mend that first")
    values = check_mbar(mbar, found.arm.nv)
    period = found.log.step if period is None else period
    time = found.model.motion.time
    if not 0.0 < period < 0.1 * (time[-1] - time[0]):
        raise ParameterError("period", f"{period!r} s given; expected more than 0 and less than a tenth of the log")
    arm, left_out = measured_arm(found)
    if found.log.torque_side == "link":
        rotors = ", ".join(f"{each:g}" for each in found.arm.armature)
        left_out.append(
            f"sensors on the links' side do not feel rotors: M(q) and the torque have those that the arm was loaded "
            f"with, ({rotors}) kg·m²"
        )
    recording = log_at_ticks(found, period)
    report = verify(arm, values, along=recording, period=period)
    return MbarAlongLog(found, report, recording, period, found.model.motion.band, tuple(left_out))


def log_at_ticks(found: Identification, period: float) -> Recording:
    """The log's motion and the torque at the joints, at multiples of a period and within the band that is fitted.

    The torque is what was logged, at the time at which it acts, less its offset and over its torque constant; of a
    sensor on the links' side with the rotors that the arm was loaded with added, which it does not feel.
    """
    assert found.fit is not None
    motion, model = found.model.motion, found.model
    of, delay = model.joint_values(found.fit.values), float(found.fit.values[model.index("delay")])
    ticks = int(np.floor((motion.time[-1] - motion.time[0]) / period + 1e-9)) + 1
    time = motion.time[0] + period * np.arange(ticks)

    def banded(values: Array) -> Array:
        inside = CubicSpline(motion.time, low_passed(values, motion.step, motion.band))
        return np.asarray(inside(np.minimum(time, motion.time[-1])))

    logged = motion.torque(np.clip(time - delay, motion.time[0], motion.time[-1]))
    torque = (logged - of["torque_offset"]) / of["torque_constant"]
    acceleration = banded(motion.a)
    if found.log.torque_side == "link":
        torque = torque + found.arm.armature * acceleration
    return Recording(
        found.log.name, time, banded(motion.q), banded(motion.v), np.asarray(torque), acceleration=acceleration
    )


def _largest(values: Array) -> Array:
    return np.asarray(np.max(np.abs(values), axis=0))


def _rms(values: Array) -> Array:
    return np.asarray(np.sqrt(np.mean(values**2, axis=0)))
