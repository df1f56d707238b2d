"""Options that say what the drives report and how: encoders, velocities, their noise."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Literal, TypeAlias

import typer

from asmc_pin.cli.options import per_joint
from asmc_pin.errors import ParameterError
from asmc_pin.words.choices import Pairing, Velocity

if TYPE_CHECKING:
    from asmc_pin.sampled.noise.sensor_model import LoopSensor

Side: TypeAlias = Literal["joint", "motor"]

VelocityOption: TypeAlias = Annotated[
    Velocity | None,
    typer.Option(
        "--velocity",
        metavar="measured|difference",
        help="How the drives make v; by difference where an encoder is named and no noise of v.",
    ),
]
VelocityFilterOption: TypeAlias = Annotated[
    float | None, typer.Option("--velocity-filter-hz", metavar="HZ", help="First-order low-pass on that difference.")
]
PairingOption: TypeAlias = Annotated[
    Pairing,
    typer.Option(
        "--pairing",
        metavar="matched|last|mean",
        help="Torque that goes with the estimate: what fits, the last one, the mean of two.",
    ),
]
EncoderBitsOption: TypeAlias = Annotated[
    str | None, typer.Option("--encoder-bits", metavar="B", help="Counts per turn, a power of 2; or one per joint.")
]
EncoderSideOption: TypeAlias = Annotated[
    Side, typer.Option("--encoder-side", metavar="joint|motor", help="Where the encoder sits.")
]
GearOption: TypeAlias = Annotated[
    str | None, typer.Option("--gear", metavar="G", help="Turns of the motor per turn of the joint; or one per joint.")
]
VelocityNoiseOption: TypeAlias = Annotated[
    str | None, typer.Option("--velocity-noise", metavar="S", help="Standard deviation of a measured v, rad/s.")
]
TorqueNoiseOption: TypeAlias = Annotated[
    str | None, typer.Option("--torque-noise", metavar="S", help="Standard deviation of the reported torque, N·m.")
]


def sensor_of(
    nv: int,
    *,
    velocity: Velocity | None,
    velocity_filter_hz: float | None,
    encoder_bits: str | None,
    encoder_side: Side,
    gear: str | None,
    velocity_noise: str | None,
    torque_noise: str | None,
) -> LoopSensor:
    """The sensors that the options describe.

    Raises:
        ParameterError: a value cannot be used, or options do not go together.
    """
    if encoder_side == "motor" and gear is None:
        raise ParameterError(
            "--gear", "is needed for an encoder at the motor: turns of the motor per turn of the joint"
        )
    if encoder_bits is None and (encoder_side == "motor" or gear is not None):
        raise ParameterError("--encoder-bits", "is needed for a gear to count: without an encoder nothing is rounded")
    from asmc_pin.sampled.noise.sensor_model import loop_sensor

    return loop_sensor(
        nv,
        velocity=velocity,
        velocity_filter_hz=velocity_filter_hz,
        encoder_bits=None if encoder_bits is None else per_joint(encoder_bits, "--encoder-bits"),
        gear=1.0 if gear is None or encoder_side == "joint" else per_joint(gear, "--gear"),
        velocity_noise=0.0 if velocity_noise is None else per_joint(velocity_noise, "--velocity-noise"),
        torque_noise=0.0 if torque_noise is None else per_joint(torque_noise, "--torque-noise"),
    )
