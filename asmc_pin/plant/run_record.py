"""What a run leaves behind."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.numerics.short_loops import short_loops
from asmc_pin.plant.plant import Plant
from asmc_pin.words.media import for_html
from asmc_pin.words.shown import Cells, Shown, figure, sparkline
from asmc_pin.words.text import printable

# Beyond a joint limit by less than this, rad (m), is round-off of a trajectory that touches it.
LIMIT_SLACK = 1e-9


@dataclass(frozen=True, slots=True)
class LimitViolation:
    """A joint outside its position limits. Limits are no end stops: the motion goes on.

    Attributes:
        trial: Index of the trial.
        joint: Name of the joint.
        time: When it was first outside, s.
        excess: How far outside it came at most, rad (m), positive above the upper and negative below the lower limit.
    """

    trial: int
    joint: str
    time: float
    excess: float


@dataclass(frozen=True, eq=False, repr=False)
class Rollout(Shown):
    """A run: what happened in every trial at every control tick; arrays are read-only.

    A trial that diverged holds NaN from the tick at which that was found.

    Attributes:
        time: t_k = k·period, shape (T,), s.
        q: Angles, shape (batch, T, nv), rad (m for prismatic joints, and so on).
        v: Velocities, shape (batch, T, nv), rad/s.
        torque: Torque that the drives apply over [t_k, t_{k+1}), after limits, delay and current loop; its mean where
            it changes within the period. Shape (batch, T, nv), N·m.
        friction_torque: Torque of friction on the joint, mean over the same interval: negative where the joint slides
            forwards, opposite to the load where it sticks. The last interval begins at the end of the run. Shape
            (batch, T, nv), N·m.
        s: Sliding variable of the law's own K_s, of what was measured, as the law has it. Shape (batch, T, nv), rad/s;
            NaN if the law has no ``ks``.
        gain: Adaptive gain of each tick, shape (batch, T, nv), rad/s²; NaN if the law's state has no ``gain``.
        q_ref: Reference, shape (T, nv), rad.
        v_ref: Its velocity, shape (T, nv), rad/s.
        a_ref: Its acceleration, shape (T, nv), rad/s².
        status: Per trial, ``"ok"`` or ``"diverged"``.
        end_time: Time of the last tick, or that at which the trial was found to have diverged, shape (batch,), s.
        joint_names: Names along the last axis.
        period: Control period, s.
        limit_violations: Joints that left their position limits.
        held_torque: What the drives held before t = 0, shape (batch, nv), N·m.
        q_measured: Angles as the law was told, `q` itself with ideal sensors. Shape (batch, T, nv), rad.
        v_measured: Velocities as the law was told, `v` itself with ideal sensors.
        torque_measured: Torque of the last period as the law was told, shape (batch, T, nv), N·m: with ideal sensors
            `held_torque`, then `torque` one tick later.
        external_torque: Mean torque of the disturbances over [t_k, t_{k+1}), shape (batch, T, nv), N·m; zeros without.
    """

    time: Array
    q: Array
    v: Array
    torque: Array
    friction_torque: Array
    s: Array
    gain: Array
    q_ref: Array
    v_ref: Array
    a_ref: Array
    status: tuple[str, ...]
    end_time: Array
    joint_names: tuple[str, ...]
    period: float
    limit_violations: tuple[LimitViolation, ...]
    held_torque: Array = None  # type: ignore[assignment]
    q_measured: Array = None  # type: ignore[assignment]
    v_measured: Array = None  # type: ignore[assignment]
    torque_measured: Array = None  # type: ignore[assignment]
    external_torque: Array = None  # type: ignore[assignment]

    def __post_init__(self) -> None:
        """Fill in what ideal sensors and an arm that nothing disturbs leave out."""
        if self.held_torque is None:
            object.__setattr__(self, "held_torque", np.zeros_like(self.torque[:, 0]))
        if self.torque_measured is None:
            told = np.concatenate([self.held_torque[:, None], self.torque[:, :-1]], axis=1)
            told = np.where(np.isnan(self.torque), np.nan, told)
            told.setflags(write=False)
            object.__setattr__(self, "torque_measured", told)
        if self.q_measured is None:
            object.__setattr__(self, "q_measured", self.q)
            object.__setattr__(self, "v_measured", self.v)
        if self.external_torque is None:
            object.__setattr__(self, "external_torque", np.broadcast_to(0.0, self.torque.shape))

    @property
    def ideal_sensor(self) -> bool:
        """Whether the law was told the truth."""
        return self.q_measured is self.q

    @property
    def warnings(self) -> tuple[str, ...]:
        """What a user ought to be told, one line per joint that left its limits in any trial."""
        lines = []
        for name in dict.fromkeys(violation.joint for violation in self.limit_violations):
            found = [violation for violation in self.limit_violations if violation.joint == name]
            first = min(found, key=lambda violation: violation.time)
            worst = max(found, key=lambda violation: abs(violation.excess))
            share = "" if len(self.status) == 1 else f" in {len(found)} of {len(self.status)} trials"
            side = "above its upper" if worst.excess > 0.0 else "below its lower"
            lines.append(
                f"joint '{name}' left its position limits{share}, first at t = {first.time:.4g} s, "
                f"and came {abs(worst.excess):.4g} {side} limit; limits are not end stops here"
            )
        return tuple(lines)

    def lines(self) -> list[str]:
        """How much was run, and what went wrong."""
        trials = len(self.status)
        said = f"{trials} trial{'s' if trials > 1 else ''} of {self.time[-1]:g} s in periods of {self.period:g} s"
        if (diverged := np.array(self.status) != "ok").any():
            said += f"; {diverged.sum()} diverged, first at t = {self.end_time[diverged].min():.4g} s"
        return [said, *self.warnings]

    def table(self) -> Cells:
        """Largest error and torque of each joint, over the trials that did not diverge; a dash where all did."""
        ran = np.array(self.status) == "ok"
        error, torque = (np.abs(x[ran]) for x in (self.q_ref - self.q, self.torque))
        rows = []
        for i, name in enumerate(self.joint_names):
            largest = (figure(float(x[..., i].max() if ran.any() else np.nan)) for x in (error, torque))
            rows.append([printable(name), *largest])
        return ["joint", "largest |e| rad (m)", "largest |τ| N·m (N)"], rows

    def picture(self) -> str:
        """The error of the first trial over time, joint by joint."""
        error = (self.q_ref - self.q[0]).T
        named = zip(map(printable, self.joint_names), error.tolist(), strict=True)
        curves = (f"<td>{sparkline(e, f'e of {name}, first trial')}<br>{for_html(name)}</td>" for name, e in named)
        return f"<table><tbody><tr>{''.join(curves)}</tr></tbody></table>"


@short_loops
def _fill_ends(q: Array, ends: Array) -> None:
    """The least and the largest value of every joint in every trial, (batch, 2, nv); NaN does not count."""
    for trial in range(q.shape[0]):
        for i in range(q.shape[2]):
            ends[trial, 0, i], ends[trial, 1, i] = np.inf, -np.inf
        for k in range(q.shape[1]):
            for i in range(q.shape[2]):
                if q[trial, k, i] < ends[trial, 0, i]:
                    ends[trial, 0, i] = q[trial, k, i]
                if q[trial, k, i] > ends[trial, 1, i]:
                    ends[trial, 1, i] = q[trial, k, i]


def outside_limits(plant: Plant, time: Array, q: Array) -> tuple[LimitViolation, ...]:
    """Every joint that left its limits, trial by trial; what comes after a divergence (NaN) does not count."""
    found = []
    ends = np.empty((len(q), 2, q.shape[2]))
    _fill_ends(q, ends)
    for joint, name in enumerate(plant.arm.joint_names):
        highest, lowest = ends[:, 1, joint], ends[:, 0, joint]
        upper, lower = (np.array([getattr(arm, side)[joint] for arm in plant.arms]) for side in ("upper", "lower"))
        for trial in np.flatnonzero((highest > upper) | (lowest < lower)).tolist():
            arm = plant.arms[trial % len(plant.arms)]
            above, below = highest[trial] - arm.upper[joint], arm.lower[joint] - lowest[trial]
            if max(above, below) > LIMIT_SLACK:
                path = q[trial, :, joint]
                outside = (path - arm.upper[joint] > LIMIT_SLACK) | (arm.lower[joint] - path > LIMIT_SLACK)
                excess = above if above >= below else -below
                found.append(LimitViolation(trial, name, float(time[np.argmax(outside)]), float(excess)))
    return tuple(found)
