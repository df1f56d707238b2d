"""The options of a sampled loop that are no gains: how q̈ and v are made, delay, and what the drives report."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, Literal, TypeAlias

import typer

from asmc_pin.cli.option_groups.grouping import option_names
from asmc_pin.cli.options import per_joint
from asmc_pin.errors import ParameterError
from asmc_pin.words.choices import Acceleration, Pairing, Velocity

if TYPE_CHECKING:
    from asmc_pin.sampled.noise.sensor_model import LoopSensor

Side: TypeAlias = Literal["joint", "motor"]


@dataclass(frozen=True, kw_only=True)
class LoopOptions:
    """What the command line says about a loop besides its gains."""

    acceleration: Annotated[
        Acceleration, typer.Option("--acceleration", metavar="velocity|position", help="How q̈(t−L) is estimated.")
    ] = "velocity"
    filter_hz: Annotated[
        float | None, typer.Option("--filter-hz", metavar="HZ", help="First-order low-pass on that estimate.")
    ] = None
    delay: Annotated[
        float, typer.Option("--delay", metavar="PERIODS", help="Transport delay of the torque, fractions allowed.")
    ] = 0.0
    velocity: Annotated[
        Velocity | None,
        typer.Option(
            "--velocity",
            metavar="measured|difference",
            help="How the drives make v; by difference where an encoder is named and no noise of v.",
        ),
    ] = None
    velocity_filter_hz: Annotated[
        float | None,
        typer.Option("--velocity-filter-hz", metavar="HZ", help="First-order low-pass on that difference."),
    ] = None
    pairing: Annotated[
        Pairing,
        typer.Option(
            "--pairing",
            metavar="matched|last|mean",
            help="Torque that goes with the estimate: what fits, the last one, the mean of two.",
        ),
    ] = "matched"
    encoder_bits: Annotated[
        str | None,
        typer.Option("--encoder-bits", metavar="B", help="Counts per turn, a power of 2; or one per joint."),
    ] = None
    encoder_side: Annotated[
        Side, typer.Option("--encoder-side", metavar="joint|motor", help="Where the encoder sits.")
    ] = "joint"
    gear: Annotated[
        str | None,
        typer.Option("--gear", metavar="G", help="Turns of the motor per turn of the joint; or one per joint."),
    ] = None
    velocity_noise: Annotated[
        str | None, typer.Option("--velocity-noise", metavar="S", help="Standard deviation of a measured v, rad/s.")
    ] = None
    torque_noise: Annotated[
        str | None,
        typer.Option("--torque-noise", metavar="S", help="Standard deviation of the reported torque, N·m."),
    ] = None

    def timing(self) -> dict[str, Any]:
        """What has no sensor in it, as keywords of `stability` and `suggest_gains`."""
        return {
            "acceleration": self.acceleration,
            "filter_hz": self.filter_hz,
            "delay": self.delay,
            "pairing": self.pairing,
        }

    def sensor(self, nv: int) -> LoopSensor:
        """The sensors of an arm of nv joints.

        Raises:
            ParameterError: a value cannot be used, or options do not go together.
        """
        if self.encoder_side == "motor" and self.gear is None:
            raise ParameterError(
                "--gear", "is needed for an encoder at the motor: turns of the motor per turn of the joint"
            )
        if self.encoder_bits is None and (self.encoder_side == "motor" or self.gear is not None):
            raise ParameterError(
                "--encoder-bits", "is needed for a gear to count: without an encoder nothing is rounded"
            )
        from asmc_pin.sampled.noise.sensor_model import loop_sensor

        def values(text: str | None, option: str, otherwise: float | None = 0.0) -> Any:
            return otherwise if text is None else per_joint(text, option)

        return loop_sensor(
            nv,
            velocity=self.velocity,
            velocity_filter_hz=self.velocity_filter_hz,
            encoder_bits=values(self.encoder_bits, "--encoder-bits", None),
            gear=1.0 if self.encoder_side == "joint" else values(self.gear, "--gear"),
            velocity_noise=values(self.velocity_noise, "--velocity-noise"),
            torque_noise=values(self.torque_noise, "--torque-noise"),
        )


BARE_LOOP = LoopOptions()
"""Nothing said about the loop."""

LOOP_NAMES = option_names(LoopOptions)
"""Names of these options, as a command's parameters have them."""
