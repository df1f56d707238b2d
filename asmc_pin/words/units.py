"""Figures that can hardly be meant in the unit that they are read in: asked about, not computed with.

Everything is in SI units, and a period in Hz, a delay in seconds or an angle in degrees gives a wrong answer that looks
like a right one. Each check leaves a way to say what is meant: whole turns of a joint change nothing and can be taken
away, and a joint that is meant to be fast declares so in its URDF. docs/units.md has the limits.
"""

from __future__ import annotations

import math
from typing import Protocol

import numpy as np

from asmc_pin._typing import Array, BoolArray
from asmc_pin.errors import ParameterError

LONGEST_PERIOD = 1.0
"""s; no arm is controlled once a second."""

SHORTEST_PERIOD = 1e-9
"""s; no computer controls an arm as fast, and squares of a shorter one are soon below what a float has."""

SHORTEST_DELAY = 0.05
"""Periods; below it a delay does not show, and is more likely in seconds."""

LONGEST_DELAY = 1000.0
"""Periods."""

FAR = 4.0 * math.pi
"""rad; where a joint declares no range, an angle beyond it is more likely in degrees."""

BEYOND = math.pi
"""rad; by how much more than its declared range an angle of a joint may be."""

FAST = 10.0 * math.pi
"""rad/s; or ten times the declared limit, if that is more."""

_TURN = 2.0 * math.pi
_DEGREES = math.degrees(1.0)


class JointsOfArm(Protocol):
    """What is looked at of an arm; limits are ±infinity where none is declared, all of shape (nv,)."""

    @property
    def joint_names(self) -> tuple[str, ...]: ...  # noqa: D102
    @property
    def joint_kinds(self) -> tuple[str, ...]: ...  # noqa: D102
    @property
    def continuous(self) -> BoolArray: ...  # noqa: D102
    @property
    def lower(self) -> Array: ...  # noqa: D102
    @property
    def upper(self) -> Array: ...  # noqa: D102
    @property
    def velocity_limit(self) -> Array: ...  # noqa: D102


def check_period(period: float, name: str = "period") -> None:
    """Ask about a control period of a second or more, a rate in Hz or milliseconds; refuse none, or one below 1 ns.

    Raises:
        ParameterError: named `name`.
    """
    if not period > 0.0:
        raise ParameterError(name, f"{period:g} given, a positive time in s expected, such as 0.001")
    said = f"{period:g} s? A control period is in seconds, and "
    if period < SHORTEST_PERIOD:
        raise ParameterError(name, f"{said}at least {SHORTEST_PERIOD:g}")
    if period >= LONGEST_PERIOD:
        meant = {"Hz": 1.0 / period, "kHz": 1e-3 / period, "ms": 1e-3 * period}
        known = [f"{period:g} {unit} is {value:.6g}" for unit, value in meant.items() if 1e-5 <= value < LONGEST_PERIOD]
        raise ParameterError(name, f"{said}below {LONGEST_PERIOD:g}" + (f": {', '.join(known)}" if known else ""))


def check_delay(delay: float, period: float, name: str = "delay") -> None:
    """Ask about a delay in periods that looks like one in seconds, or that no loop has.

    Args:
        delay: Periods.
        period: Control period, s.
        name: Of the parameter.

    Raises:
        ParameterError: named `name`.
    """
    if 0.0 < delay < SHORTEST_DELAY:
        raise ParameterError(
            name,
            f"{delay:g} periods of {period:g} s are {delay * period:.3g} s? A delay is in control periods: {delay:g} s "
            f"are {delay / period:.6g} of them; less than {SHORTEST_DELAY:g} of a period does not show, leave it out",
        )
    if delay > LONGEST_DELAY:
        raise ParameterError(
            name,
            f"{delay:g} periods of {period:g} s are {delay * period:.4g} s? A delay is in control periods, at most "
            f"{LONGEST_DELAY:g}: {delay:g} µs are {1e-6 * delay / period:.6g} of them",
        )


def check_gravity(gravity: Array, name: str = "gravity") -> None:
    """Ask about a gravity in multiples of g, or in mm/s²; shape (3,), m/s².

    Raises:
        ParameterError: named `name`.
    """
    size = float(np.linalg.norm(gravity))
    given = ", ".join(f"{x:g}" for x in gravity)
    if abs(size - 1.0) < 0.02:
        standard = ", ".join(f"{9.81 * x + 0.0:.4g}" for x in gravity)
        raise ParameterError(name, f"({given}) m/s²? Gravity is in m/s², and not in g: on Earth that is ({standard})")
    if size > 100.0:
        metres = ", ".join(f"{1e-3 * x:g}" for x in gravity)
        raise ParameterError(name, f"({given}) m/s²? Gravity is in m/s²: ({given}) mm/s² is ({metres})")


def check_angle(name: str, joint: str, angle: float, lower: float, upper: float, continuous: bool) -> None:
    """Ask about an angle at which a turning joint is to stand.

    Args:
        name: Of the parameter.
        joint: Its name.
        angle: rad.
        lower: Declared limit, rad; infinite where there is none.
        upper: The same.
        continuous: Whether it turns without end.

    Raises:
        ParameterError: named `name`.
    """
    least, most = _reach(lower, upper, continuous)
    if not least <= angle <= most:
        raise ParameterError(
            name,
            f"joint '{joint}': {angle:g} rad? Angles are in rad: {angle:g}° are {math.radians(angle):.6g}; if rad is "
            f"meant, take whole turns away: {math.remainder(angle, _TURN):.6g}",
        )


def check_range(name: str, arm: JointsOfArm, lower: Array, upper: Array) -> None:
    """Ask about a joint box whose angles look like degrees; ends of shape (nv,), rad (m where prismatic).

    Raises:
        ParameterError: named `name`.
    """
    for i, joint in enumerate(arm.joint_names):
        least, most = _reach(float(arm.lower[i]), float(arm.upper[i]), bool(arm.continuous[i]))
        lo, hi = float(lower[i]), float(upper[i])
        if arm.joint_kinds[i] == "revolute" and not (least <= lo and hi <= most):
            raise ParameterError(
                name,
                f"joint '{joint}': {lo:g}:{hi:g} rad? Angles are in rad: {lo:g}:{hi:g} degrees are "
                f"{math.radians(lo):.6g}:{math.radians(hi):.6g}; a turning joint needs one turn at most, "
                f"{-math.pi:.6g}:{math.pi:.6g}",
            )


def check_reach(name: str, width: Array, slides: BoolArray) -> None:
    """Ask about a tube that reaches more than half a turn to either side, shape (nv,), rad (m where prismatic).

    Raises:
        ParameterError: named `name`.
    """
    wide = float(np.max(width, initial=0.0, where=~slides))
    if wide > math.pi:
        raise ParameterError(
            name,
            f"{wide:g} rad to either side? That is a whole turn and more; angles are in rad: {wide:g}° are "
            f"{math.radians(wide):.6g}; for the whole joint box leave the motion out",
        )


def check_motion(
    name: str, arm: JointsOfArm, what: str, time: Array, q: Array, v: Array | None = None, *, recorded: bool = False
) -> None:
    """Ask about a motion whose angles look like degrees.

    A joint with a declared range may not leave it by more than half a turn; one without may not start more than two
    turns from zero. None may be faster than five turns a second or ten times its declared limit. What is recorded may
    in single rows, for a reading may jump, and its velocities have to belong to its angles.

    Args:
        name: Of the parameter.
        arm: Whose joints move.
        what: The motion, in words.
        time: Shape (T,), s.
        q: Shape (T, nv), rad (m where prismatic).
        v: Shape (T, nv), rad/s; differences of q where None.
        recorded: Whether it was measured.

    Raises:
        ParameterError: named `name`.
    """
    hint = (
        "Angles are in rad, 180° are 3.14159: multiply them by 0.0174533; whole turns of 6.28319 may be taken away, "
        "and a joint that is so fast declares its velocity limit in the URDF"
    )
    turning = [i for i, kind in enumerate(arm.joint_kinds) if kind == "revolute"]
    for i in turning:
        joint = f"joint '{arm.joint_names[i]}'"
        limited = not arm.continuous[i] and math.isfinite(arm.upper[i] - arm.lower[i])
        least, most = _reach(float(arm.lower[i]), float(arm.upper[i]), bool(arm.continuous[i]))
        looked_at = q[:, i] if limited else q[:1, i]
        out = np.flatnonzero((looked_at < least) | (looked_at > most))
        if out.size:
            at = int(out[np.argmax(np.abs(looked_at[out]))])
            limits = f", with limits {arm.lower[i]:.4g} … {arm.upper[i]:.4g} rad" if limited else ""
            raise ParameterError(
                name, f"{what} has {joint} at {q[at, i]:.5g} rad, t = {time[at]:.4g} s{limits}: degrees? {hint}"
            )
    if len(time) < 2 or not turning:
        return
    change = np.gradient(q, time, axis=0)
    if recorded and v is not None:
        _check_together(name, what, np.abs(change[:, turning]), np.abs(v[:, turning]))
    speed = np.abs(change if v is None or recorded else v)
    for i in turning:
        limit = float(arm.velocity_limit[i])
        most = max(FAST, 10.0 * limit if math.isfinite(limit) else 0.0)
        fast = float(np.quantile(speed[:, i], 0.95)) if recorded else float(speed[:, i].max())
        if fast > most:
            raise ParameterError(name, f"{what} has joint '{arm.joint_names[i]}' at {fast:.4g} rad/s: degrees? {hint}")


def _check_together(name: str, what: str, change: Array, speed: Array) -> None:
    """Angles that change 57.3 times as fast as the velocities say, or the other way round; both (T, joints)."""
    moving = speed > 0.5 * speed.max(axis=0, initial=0.0, keepdims=True)
    moving &= speed > 0.0
    if not moving.any():
        return
    ratio = float(np.median(change[moving] / speed[moving]))
    for factor, which in ((_DEGREES, "angles in degrees"), (1.0 / _DEGREES, "velocities in degrees per second")):
        if 0.8 < ratio / factor < 1.25:
            raise ParameterError(
                name,
                f"{what}: its angles change {ratio:.3g} times as fast as its velocities say: {which}? Both are in rad, "
                "at the joints: multiply degrees by 0.0174533",
            )


def _reach(lower: float, upper: float, continuous: bool) -> tuple[float, float]:
    """Least and largest angle that is not asked about, rad."""
    if continuous or not math.isfinite(upper - lower):
        return -FAR, FAR
    return lower - BEYOND, upper + BEYOND
