"""The options of the gains that `design` is to choose."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import typer

from asmc_pin.cli.option_groups.law_options import SetOption


@dataclass(frozen=True, kw_only=True)
class GainOptions:
    """What the command line says about gains besides their loop."""

    gains: Annotated[bool, typer.Option("--gains", help="Also β and K_s with margins; needs --period.")] = False
    period: Annotated[str | None, typer.Option(metavar="S", help="Control period for --gains.")] = None
    gain_margin: Annotated[float, typer.Option(help="Factor by which the torque gain may be off, for --gains.")] = 2.0
    delay_margin: Annotated[float, typer.Option(help="Delay that may come on top, periods, for --gains.")] = 1.0
    law: Annotated[
        str | None,
        typer.Option(metavar="dob|implicit", help="For --gains: the law to choose for, and what it is worth over ppc."),
    ] = None
    settings: SetOption = None
    coulomb: Annotated[
        str | None,
        typer.Option(metavar="C1,C2,…", help="Coulomb friction for the prediction, N·m; the URDF's if omitted."),
    ] = None
    yaml: Annotated[
        str | None,
        typer.Option(
            metavar="FILE",
            help="For --gains: those of the PID that (7) is with backward differences, as ros2_control's parameters.",
        ),
    ] = None
    noise_budget: Annotated[
        str | None,
        typer.Option(
            metavar="N1,N2,…",
            help="Torque RMS that noise may make, N·m per joint, for --gains: filter_hz is chosen too.",
        ),
    ] = None


NO_GAINS = GainOptions()
"""Gains that are not asked for."""
