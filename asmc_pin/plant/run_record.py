"""What a run leaves behind."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.errors import ParameterError
from asmc_pin.words.media import for_html
from asmc_pin.words.shown import Cells, Shown, figure, sparkline
from asmc_pin.words.text import printable


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
    """A run: what happened in every trial at every control tick that is logged; arrays are read-only.

    A trial that diverged holds NaN from the tick at which that was found. Where `log_every` is N, the T ticks are 0, N,
    2N and so on, each with what a run that logs every tick has of it; what needs every tick, such as a metric, is
    refused.

    Attributes:
        time: t_k = k·period of the ticks, shape (T,), s.
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
            `held_torque`, then `torque` one tick later. NaN where nobody gives it and not every tick is logged.
        external_torque: Mean torque of the disturbances over [t_k, t_{k+1}), shape (batch, T, nv), N·m; zeros without.
        log_every: One control tick in how many is logged.
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
    log_every: int = 1

    def __post_init__(self) -> None:
        """Fill in what ideal sensors and an arm that nothing disturbs leave out."""
        if self.held_torque is None:
            object.__setattr__(self, "held_torque", np.zeros_like(self.torque[:, 0]))
        if self.torque_measured is None:
            told = np.concatenate([self.held_torque[:, None], self.torque[:, :-1]], axis=1)
            told = np.where(np.isnan(self.torque) | (self.log_every != 1), np.nan, told)
            told.setflags(write=False)
            object.__setattr__(self, "torque_measured", told)
        if self.q_measured is None:
            object.__setattr__(self, "q_measured", self.q)
            object.__setattr__(self, "v_measured", self.v)
        if self.external_torque is None:
            object.__setattr__(self, "external_torque", np.broadcast_to(0.0, self.torque.shape))

    def need_every_tick(self, what: str) -> None:
        """Refuse what is computed from every tick where some are not logged.

        Args:
            what: That, with its verb, such as ``"metrics are"``.

        Raises:
            ParameterError: ticks are missing.
        """
        if self.log_every != 1:
            raise ParameterError(
                "log_every",
                f"this run has logged one tick in {self.log_every}, and {what} computed from every tick; run it with "
                "log_every = 1",
            )

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
        end = f"{'of' if self.log_every == 1 else 'up to'} {self.time[-1]:g} s in periods of {self.period:g} s"
        said = f"{trials} trial{'s' if trials > 1 else ''} {end}"
        said += "" if self.log_every == 1 else f", one tick in {self.log_every} logged"
        if (diverged := np.array(self.status) != "ok").any():
            said += f"; {diverged.sum()} diverged, first at t = {self.end_time[diverged].min():.4g} s"
        return [said, *self.warnings]

    def table(self) -> Cells:
        """Largest logged error and torque of each joint, over the trials that did not diverge; a dash where all did."""
        ran = np.array(self.status) == "ok"
        error, torque = (np.abs(x[ran]) for x in (self.q_ref - self.q, self.torque))
        rows = []
        for i, name in enumerate(self.joint_names):
            largest = (figure(float(x[..., i].max() if ran.any() else np.nan)) for x in (error, torque))
            rows.append([printable(name), *largest])
        largest_is = "largest" if self.log_every == 1 else "largest logged"
        return ["joint", f"{largest_is} |e| rad (m)", f"{largest_is} |τ| N·m (N)"], rows

    def picture(self) -> str:
        """The error of the first trial over time, joint by joint."""
        error = (self.q_ref - self.q[0]).T
        named = zip(map(printable, self.joint_names), error.tolist(), strict=True)
        curves = (f"<td>{sparkline(e, f'e of {name}, first trial')}<br>{for_html(name)}</td>" for name, e in named)
        return f"<table><tbody><tr>{''.join(curves)}</tr></tbody></table>"
