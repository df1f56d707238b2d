"""What the drives report of the joints: encoders, and how velocity is made from them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.errors import ParameterError
from asmc_pin.parameters import Choice, OptionalPerJoint, PerJoint, Scalar
from asmc_pin.plant.per_trial import row, sized
from asmc_pin.words.encoder_counts import MOST_BITS, encoder_count


@dataclass(frozen=True, kw_only=True, eq=False)
class Sensor:
    """Encoders of the joints, and the velocity that is computed from what they report.

    A reading is the angle, `delay` periods ago, with Gaussian noise, rounded to the encoder's resolution. Velocity is
    made from the readings, unless it is asked for ``"exact"``, as if there were a tachometer. The reported torque is
    the drive's, without delay.

    Noise is drawn per trial from the experiment's seed and the trial's number: a trial has the same noise in any batch,
    on any worker, and under every law.
    """

    bits: OptionalPerJoint = OptionalPerJoint(
        "counts per turn of the encoder, as a power of 2", "", above=0.0, at_most=MOST_BITS
    )
    resolution: OptionalPerJoint = OptionalPerJoint("angle (length) of one count of the encoder", "rad (m)", above=0.0)
    side: Choice = Choice("where the encoder sits: after the gear, or before it", ("joint", "motor"), default="joint")
    position_noise: PerJoint = PerJoint(
        "standard deviation of a reading, at the joint", "rad (m)", at_least=0.0, default=0.0
    )
    velocity: Choice = Choice(
        "velocity from the difference of readings, that filtered, or exact",
        ("difference", "filter", "exact"),
        default="difference",
    )
    filter_hz: Scalar = Scalar("corner of the velocity filter, first order", "Hz", above=0.0, default=100.0)
    velocity_noise: PerJoint = PerJoint(
        "standard deviation of the exact velocity", "rad/s (m/s)", at_least=0.0, default=0.0
    )
    torque_noise: PerJoint = PerJoint("standard deviation of the reported torque", "N·m (N)", at_least=0.0, default=0.0)
    delay: Scalar = Scalar("age of a reading when the law gets it", "periods", at_least=0.0, default=0.0)

    def __post_init__(self) -> None:
        """Check what depends on several parameters."""
        if self.bits is not None and self.resolution is not None:
            raise ParameterError("resolution", "given together with bits; one of them says how fine the encoder is")
        if self.velocity != "exact" and np.any(self.velocity_noise > 0.0):
            raise ParameterError(
                "velocity_noise",
                f"given with velocity = {self.velocity!r}, which has the noise of the readings; "
                "it is for velocity = 'exact'",
            )

    def check(self, joint_kinds: tuple[str, ...], joint_names: tuple[str, ...]) -> None:
        """Check the parameters against an arm.

        Raises:
            ParameterError: wrong sizes, or bits for a joint that slides.
        """
        sized("sensor", self, len(joint_names))
        if self.bits is not None and self.side == "joint" and "prismatic" in joint_kinds:
            name = joint_names[joint_kinds.index("prismatic")]
            raise ParameterError(
                "sensor.bits",
                f"joint '{name}' slides and has no turns to divide; give resolution in m, or side = 'motor'",
            )

    def count(self, nv: int, gear: Array) -> Array:
        """Angle (length) of one count at the joint, shape (nv,), rad (m); 0 where readings are not rounded.

        Args:
            nv: Number of joints.
            gear: Turns of the motor per turn of the joint, shape () or (nv,).
        """
        size = row(self.resolution, nv, 0.0) if self.bits is None else encoder_count(row(self.bits, nv, 0.0))
        return size / gear if self.side == "motor" else size
