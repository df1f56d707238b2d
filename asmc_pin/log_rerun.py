"""Measured against simulated: a law of an experiment in the place of the one that made a log.

Takes an identification and an experiment; gives the run of one of its laws on the plant as measured, along the log's
own motion. May import what makes an experiment and runs it.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any, ClassVar

import numpy as np
from scipy.interpolate import BSpline, make_interp_spline

from asmc_pin._typing import Array
from asmc_pin.condition import Recording
from asmc_pin.controllers.protocol import Setpoint
from asmc_pin.engine import Rollout, rollout
from asmc_pin.errors import ExperimentError, ParameterError
from asmc_pin.experiment import load_experiment
from asmc_pin.identification.identification_report import Identification
from asmc_pin.identification.mbar_along_log import log_at_ticks
from asmc_pin.identification.plant_tables import plant_tables
from asmc_pin.logs.resampling import low_passed
from asmc_pin.references.feasibility import check_reference
from asmc_pin.references.reference import as_times, held_outside
from asmc_pin.words.shown import Cells, Shown, figure
from asmc_pin.words.text import printable, quoted


@dataclass(frozen=True, eq=False)
class LoggedMotion:
    """The motion of a log as a reference: a spline of degree five through its low-passed angles.

    Attributes:
        curve: Of the angles over time, from 0 on.
        duration: s.
        nv: Number of joints.
    """

    motion: ClassVar[str] = "the motion of a log"

    curve: BSpline
    duration: float
    nv: int

    def evaluate(self, t: Array) -> Setpoint:
        """The reference at the times t, (T,), s; fields of shape (T, nv). Before and after the log it rests."""
        t = as_times(t)
        inside = (t >= 0.0) & (t <= self.duration)
        q, v, a = (np.asarray(self.curve(np.clip(t, 0.0, self.duration), nu)) for nu in range(3))
        return held_outside(inside, q, v, a)


@dataclass(frozen=True, eq=False, repr=False)
class LawOnLog(Shown):
    """A law that ran in the place of the one that made a log.

    Attributes:
        found: What was identified of the log.
        experiment: Name of the experiment that the law is from.
        label: Of the law in it.
        mbar: Its M̄, shape (nv,), kg·m²; None of a law that has none.
        run: What it did on the plant as measured.
        measured: The log's motion and torque at the same ticks, below `band`.
        torque: The simulated torque below `band`, shape (T, nv), N·m.
        error: Tracking error of the simulated law, shape (T, nv), rad.
        smoothed_off: Logged angles less the motion that was followed, shape (T, nv), rad.
        band: Hz.
        warnings: Limits that the log's motion asks more than, on the arm as measured.
    """

    found: Identification
    experiment: str
    label: str
    mbar: Array | None
    run: Rollout
    measured: Recording
    torque: Array
    error: Array
    smoothed_off: Array
    band: float
    warnings: tuple[str, ...]

    @property
    def difference(self) -> Array:
        """RMS of simulated − measured torque, shape (nv,), N·m; NaN where the law diverged."""
        assert self.measured.torque is not None
        return _rms(self.torque - self.measured.torque)

    def headline(self) -> str:
        """How it went."""
        name = f"{quoted(self.label)} of {printable(self.experiment)} in the log's place"
        if self.run.status[0] != "ok":
            return f"{name}: diverged at t = {self.run.end_time[0]:.4g} s"
        return f"{name}: ran through, largest tracking error {np.max(np.abs(self.error)):.3g} rad"

    def lines(self) -> list[str]:
        """How it went, what it followed, and what was beyond a limit."""
        return [
            self.headline(),
            f"it followed the log's angles below {self.band:g} Hz, a spline of degree five through them, on the arm "
            "and friction as measured, with the experiment's drives and sensors; torques are compared below "
            f"{self.band:g} Hz",
            *(f"the log's motion asks for more than there is: {line}" for line in self.warnings),
        ]

    def table(self) -> Cells:
        """RMS of torque and tracking, measured and simulated, joint by joint."""
        assert self.measured.torque is not None
        columns = (
            _rms(self.measured.torque),
            _rms(self.torque),
            self.difference,
            _rms(self.smoothed_off),
            _rms(self.error),
        )
        rows = [
            [printable(name), *(figure(float(column[j]), ".3g") for column in columns)]
            for j, name in enumerate(self.found.arm.joint_names)
        ]
        head = ["measured torque", "simulated", "difference", "logged − motion followed, rad", "tracking error, rad"]
        return ["joint (RMS, N·m)", *head], rows

    def to_json_dict(self) -> dict[str, Any]:
        """What ``identify --law --json`` says under ``law``; undefined figures are None."""
        assert self.measured.torque is not None
        ok = self.run.status[0] == "ok"
        return {
            "experiment": self.experiment,
            "label": self.label,
            "status": self.run.status[0],
            "period": self.run.period,
            "band_hz": self.band,
            "torque_rms_measured": _rms(self.measured.torque).tolist(),
            "torque_rms_simulated": _rms(self.torque).tolist() if ok else None,
            "torque_rms_difference": self.difference.tolist() if ok else None,
            "tracking_rms": _rms(self.error).tolist() if ok else None,
            "tracking_max": np.max(np.abs(self.error), axis=0).tolist() if ok else None,
            "warnings": list(self.warnings),
        }


def law_on_log(found: Identification, experiment: str, label: str) -> LawOnLog:
    """Run a law of an experiment on the plant as measured, along the motion of the log it was measured by.

    Args:
        found: With estimates.
        experiment: Name or path of an experiment on the same arm; its drives, sensors, period and law are taken, its
            arm and friction are laid over by what was measured.
        label: Which of its controllers.

    Raises:
        ParameterError: Nothing was estimated.
        ExperimentError: There is no such experiment or controller, or its arm is another one.
    """
    if found.fit is None:
        raise ParameterError("law", "the log contradicts the URDF, so there is no plant to run a law on")
    tables = plant_tables(found)
    # What the log was identified with, and not what the experiment's arm carries, where no payload came out.
    own = found.arm.payload
    tables["arm"].setdefault("payload", {"mass": 0.0} if own is None else asdict(own))
    tables["arm"].setdefault("armature", found.arm.armature.tolist())
    loaded = load_experiment(experiment, plant=tables)
    laws = loaded.build_controllers()
    if label not in laws:
        known = ", ".join(quoted(each) for each in laws)
        raise ExperimentError("controllers", f"{loaded.name} has no controller {quoted(label)}; it has {known}")
    motion = found.model.motion
    start = motion.time[0]
    followed = low_passed(motion.raw_q, motion.step, motion.band)
    reference = LoggedMotion(
        make_interp_spline(motion.time - start, followed, k=5), float(motion.time[-1] - start), found.arm.nv
    )
    plant = loaded.build_plant()
    warnings = check_reference(
        reference,
        plant.arm,
        reference.duration,
        loaded.period,
        coulomb=np.broadcast_to(plant.friction.coulomb, found.arm.nv),
        viscous=np.broadcast_to(plant.friction.viscous, found.arm.nv),
        effort_limit=np.asarray(plant.effort_limit),
    )
    run = rollout(plant, laws[label], reference, reference.duration, period=loaded.period)
    measured = log_at_ticks(found, loaded.period)
    ticks = min(len(measured.time), len(run.time))
    measured = _first(measured, ticks)
    logged = np.column_stack([np.interp(measured.time - start, motion.time - start, q) for q in motion.raw_q.T])
    mbar = getattr(laws[label], "mbar", None)
    return LawOnLog(
        found=found,
        experiment=loaded.name,
        label=label,
        mbar=None if mbar is None else np.array(np.broadcast_to(mbar, (found.arm.nv,)), dtype=np.float64),
        run=run,
        measured=measured,
        torque=low_passed(run.torque[0, :ticks], loaded.period, motion.band)
        if run.status[0] == "ok"
        else run.torque[0, :ticks],
        error=run.q_ref[:ticks] - run.q[0, :ticks],
        smoothed_off=logged - run.q_ref[:ticks],
        band=motion.band,
        warnings=tuple(warnings),
    )


def _first(recording: Recording, ticks: int) -> Recording:
    cut = [recording.q, recording.v, recording.torque, recording.acceleration]
    q, v, torque, acceleration = (None if each is None else each[:ticks] for each in cut)
    assert q is not None
    return Recording(recording.name, recording.time[:ticks], q, v, torque, acceleration)


def _rms(values: Array) -> Array:
    return np.asarray(np.sqrt(np.mean(values**2, axis=0)))
