"""What the sensors of a loop do to it: how v is made, how old readings are, and how far they are off."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from asmc_pin._typing import Array
from asmc_pin.errors import ParameterError
from asmc_pin.sampled.sampled_loop import Velocity
from asmc_pin.words.encoder_counts import MOST_BITS, encoder_count


@dataclass(frozen=True, eq=False)
class LoopSensor:
    """Sensors as the linear analysis takes them; validated, every figure per joint, at the joint.

    Attributes:
        velocity: "measured", or the "difference" of two readings of the angle.
        velocity_filter_hz: Low-pass on that difference, Hz; None for none.
        reading_delay: Age of a reading, periods.
        count: Angle (length) of one count of the encoder, shape (nv,), rad (m); 0 where readings are not rounded.
        angle_noise: Standard deviation of a reading, before it is rounded, likewise.
        rate_noise: Standard deviation of a measured velocity, shape (nv,), rad/s.
        torque_noise: Standard deviation of the reported torque, shape (nv,), N·m.
    """

    count: Array
    angle_noise: Array
    rate_noise: Array
    torque_noise: Array
    velocity: Velocity = "measured"
    velocity_filter_hz: float | None = None
    reading_delay: float = 0.0

    def __post_init__(self) -> None:
        """Check what depends on two of them."""
        if self.velocity != "measured" and self.rate_noise.any():
            raise ParameterError(
                "velocity_noise", "is of a velocity that is measured; a difference has the noise of the readings"
            )

    @property
    def timing(self) -> dict[str, Any]:
        """What of it changes the loop, as arguments of `SampledLoop`."""
        return {
            "velocity": self.velocity,
            "velocity_filter_hz": self.velocity_filter_hz,
            "reading_delay": self.reading_delay,
        }

    @property
    def noisy(self) -> bool:
        """Whether anything that it reports is off."""
        return bool(any(x.any() for x in (self.count, self.angle_noise, self.rate_noise, self.torque_noise)))


def loop_sensor(
    nv: int,
    *,
    velocity: Velocity | None = None,
    velocity_filter_hz: float | None = None,
    encoder_bits: ArrayLike | None = None,
    gear: ArrayLike = 1.0,
    angle_noise: ArrayLike = 0.0,
    velocity_noise: ArrayLike = 0.0,
    torque_noise: ArrayLike = 0.0,
) -> LoopSensor:
    """Sensors from what a data sheet says.

    Args:
        nv: Number of joints.
        velocity: How v is made; by default by difference where there is an encoder and no noise of v is given.
        velocity_filter_hz: See `LoopSensor`.
        encoder_bits: Counts per turn of the encoder, as a power of 2; a number or nv of them.
        gear: Turns of the encoder per turn of the joint: the gear's ratio where it sits at the motor.
        angle_noise: See `LoopSensor`.
        velocity_noise: Standard deviation of a measured velocity, rad/s.
        torque_noise: See `LoopSensor`.

    Raises:
        ParameterError: a value has a wrong size or sign, or is not finite.
    """
    spread = {
        name: nonnegative_per_joint(name, value, nv, unit)
        for name, value, unit in (
            ("angle_noise", angle_noise, "rad"),
            ("velocity_noise", velocity_noise, "rad/s"),
            ("torque_noise", torque_noise, "N·m"),
        )
    }
    count = np.zeros(nv)
    if encoder_bits is not None:
        turns = nonnegative_per_joint("gear", gear, nv, "turns of the encoder per turn of the joint")
        bits = nonnegative_per_joint("encoder_bits", encoder_bits, nv, "powers of 2")
        for name, values in (("gear", turns), ("encoder_bits", bits)):
            if not (values > 0.0).all():
                raise ParameterError(name, f"got {values.tolist()}; every value must be above 0")
        if (bits > MOST_BITS).any():
            raise ParameterError("encoder_bits", f"got {bits.tolist()}; every value must be at most {MOST_BITS}")
        count = encoder_count(bits) / turns
    if velocity is None:
        velocity = "difference" if encoder_bits is not None and not spread["velocity_noise"].any() else "measured"
    return LoopSensor(
        count=count,
        angle_noise=spread["angle_noise"],
        rate_noise=spread["velocity_noise"],
        torque_noise=spread["torque_noise"],
        velocity=velocity,
        velocity_filter_hz=velocity_filter_hz,
    )


def nonnegative_per_joint(name: str, value: ArrayLike, nv: int, unit: str) -> Array:
    """A value of 0 or more per joint, from a scalar or nv values; a `ParameterError` where it is none."""
    try:
        values = np.array(np.broadcast_to(np.asarray(value, dtype=np.float64), (nv,)))
    except (TypeError, ValueError):
        raise ParameterError(name, f"got {value!r}; expected a number or {nv} of them, in {unit}") from None
    if not (np.isfinite(values).all() and (values >= 0.0).all()):
        raise ParameterError(name, f"got {values.tolist()}; every value must be finite and 0 or more ({unit})")
    return values
