"""Whether an arm can follow a reference at all: its position, velocity and torque limits along the motion."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Protocol, runtime_checkable

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.controllers.protocol import Setpoint
from asmc_pin.errors import ParameterError
from asmc_pin.references.reference import Reference


class LimitedArm(Protocol):
    """What the check needs of an arm; limits are ±infinity where none is declared, all of shape (nv,)."""

    @property
    def name(self) -> str: ...  # noqa: D102
    @property
    def nv(self) -> int: ...  # noqa: D102
    @property
    def joint_names(self) -> tuple[str, ...]: ...  # noqa: D102
    @property
    def joint_kinds(self) -> tuple[str, ...]: ...  # noqa: D102
    @property
    def lower(self) -> Array: ...  # noqa: D102
    @property
    def upper(self) -> Array: ...  # noqa: D102
    @property
    def velocity_limit(self) -> Array: ...  # noqa: D102
    @property
    def effort_limit(self) -> Array: ...  # noqa: D102
    @property
    def friction(self) -> Array: ...  # noqa: D102
    @property
    def damping(self) -> Array: ...  # noqa: D102

    def mass_matrix(self, q: Array) -> Array: ...  # noqa: D102
    def bias(self, q: Array, v: Array) -> Array: ...  # noqa: D102


@runtime_checkable
class Smoothable(Protocol):
    """A motion through the rows of a file, which may be smoother than they are."""

    smoothing: str
    resolution: Array | None
    times: Array
    deviation: Array

    def smoother(self) -> Iterator[Smoothable]: ...  # noqa: D102
    def evaluate(self, t: Array) -> Setpoint: ...  # noqa: D102


def required_torque(
    arm: LimitedArm, motion: Setpoint, *, coulomb: Array | None = None, viscous: Array | None = None
) -> Array:
    """Inverse dynamics with friction, τ = M(q) a + C(q, v) v + g(q) + coulomb sgn(v) + viscous v.

    Args:
        arm: The arm.
        motion: Fields of shape (T, nv).
        coulomb: (nv,), N·m; the URDF's if None. A joint at rest is taken to need none of it.
        viscous: (nv,), N·m·s/rad; the URDF's if None.

    Returns:
        Torque, shape (T, nv), N·m (N for prismatic joints).
    """
    coulomb = arm.friction if coulomb is None else coulomb
    viscous = arm.damping if viscous is None else viscous
    inertial: Array = np.einsum("tij,tj->ti", arm.mass_matrix(motion.q), motion.a)
    torque: Array = inertial + arm.bias(motion.q, motion.v) + coulomb * np.sign(motion.v) + viscous * motion.v
    return torque


def check_reference(
    reference: Reference,
    arm: LimitedArm,
    duration: float,
    period: float = 1e-3,
    *,
    coulomb: Array | None = None,
    viscous: Array | None = None,
    effort_limit: Array | None = None,
) -> list[str]:
    """Compare a reference, at the control ticks of a run, with what the arm is made for.

    Args:
        reference: The motion.
        arm: The arm, payload included.
        duration: Of the run, s.
        period: Of the control ticks at which it looks, s.
        coulomb: Friction of the run, (nv,), N·m; the URDF's if None.
        viscous: Likewise, N·m·s/rad.
        effort_limit: Torque limits of the run, (nv,), N·m; the URDF's if None.

    Returns:
        One warning for every limit of a joint that is exceeded, with the worst value, the limit and the time; and for a
        motion that stops with a jump in velocity, or whose columns are named unlike the arm's joints. Empty if all is
        well.

    Raises:
        ParameterError: the reference is for another number of joints.
    """
    if reference.nv != arm.nv:
        raise ParameterError(
            "reference", f"is for {reference.nv} joint(s) but {arm.name} has {arm.nv}: {', '.join(arm.joint_names)}"
        )
    time: Array = period * np.arange(round(duration / period) + 1, dtype=np.float64)
    motion = reference.evaluate(time)
    torque = required_torque(arm, motion, coulomb=coulomb, viscous=viscous)
    effort = arm.effort_limit if effort_limit is None else np.broadcast_to(effort_limit, (arm.nv,))
    warnings, breaking = _name_warnings(reference, arm), []
    for i, name in enumerate(arm.joint_names):
        angle, force = ("m", "N") if arm.joint_kinds[i] == "prismatic" else ("rad", "N·m")
        quantities = (
            ("position", angle, motion.q[:, i], arm.lower[i], arm.upper[i]),
            ("velocity", f"{angle}/s", motion.v[:, i], -arm.velocity_limit[i], arm.velocity_limit[i]),
            ("torque", force, torque[:, i], -effort[i], effort[i]),
        )
        for quantity, unit, values, low, high in quantities:
            text = _excess(values, float(low), float(high), unit, time)
            if text:
                warnings.append(f"joint {name!r}: {quantity} {text}")
                breaking += [i] if quantity == "torque" else []
        if reference.duration < duration:
            speed = float(reference.evaluate(np.array([reference.duration])).v[0, i])
            if abs(speed) > 1e-9:
                warnings.append(
                    f"joint {name!r}: the reference ends at t = {reference.duration:.3f} s while it moves at "
                    f"{speed:.3g} {angle}/s and is held from there on; let it end at rest or shorten the run"
                )
    if breaking and isinstance(reference, Smoothable):

        def keeps(other: Smoothable) -> bool:
            again = required_torque(arm, other.evaluate(time), coulomb=coulomb, viscous=viscous)
            return bool((np.abs(again) <= effort * (1.0 + 1e-9)).all())

        said = _cause(reference, next(filter(keeps, reference.smoother()), None))
        warnings += [f"the torque beyond its limit at {', '.join(repr(arm.joint_names[i]) for i in breaking)} {said}"]
    return warnings


def _cause(reference: Smoothable, kept: Smoothable | None) -> str:
    """Where torques beyond a limit along a file's rows come from, and which key mends it.

    Args:
        reference: The motion.
        kept: The least smoothed one that keeps the limits; None where none of them does.
    """
    if kept is None:
        return (
            "is what the motion asks for, also where it is smoothed as a log, to within 0.5 % of each joint's range: "
            "slow it down with reference.stretch"
        )
    far, step = kept.deviation, float(np.median(np.diff(reference.times)))
    worst = int(np.argmax(far))
    said = (
        f"comes of the rows and not of the motion: smoothed to within {far[worst]:.2g} rad RMS it keeps the limits, "
        f"and as much from one row to the next, {step:.3g} s, is an acceleration of {far[worst] / step**2:.3g} rad/s²; "
        "give "
    )
    if reference.smoothing == "none" and kept.resolution is None:
        return said + 'reference.smoothing = "quantisation"'
    listed = ", ".join(f"{x:.2g}" for x in np.sqrt(12.0) * far)
    return said + f'reference.smoothing = "quantisation" and resolution = [{listed}]'


def _excess(values: Array, low: float, high: float, unit: str, time: Array) -> str:
    """The worst value outside low…high, in words; empty if there is none. One rounding error is no excess."""
    beyond = np.maximum(values - high, low - values)
    k = int(np.argmax(beyond))
    value = float(values[k])
    limit = high if value > high else low
    if beyond[k] <= 1e-9 * max(1.0, abs(limit)):
        return ""
    share = float(np.mean(beyond > 0.0))
    figures = f"{value:.4g} {unit} at t = {time[k]:.3f} s, limit {limit:.4g} {unit}"
    return f"{figures} (exceeded during {100.0 * share:.2g} % of the run)"


def _name_warnings(reference: Reference, arm: LimitedArm) -> list[str]:
    named = getattr(reference, "joint_names", None)
    if named is None or tuple(named) == tuple(arm.joint_names):
        return []
    return [
        f"the reference's columns are {', '.join(named)} but the joints of {arm.name} are "
        f"{', '.join(arm.joint_names)}; they are taken in the order of the file unless joints = [...] says otherwise"
    ]
