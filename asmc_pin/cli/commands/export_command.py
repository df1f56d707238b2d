"""`asmc-pin export`: a controller of an experiment as code for a robot."""

from __future__ import annotations

import math
from typing import Annotated

import typer

from asmc_pin.cli.app import ROBOT, app
from asmc_pin.cli.commands.study_commands import ExperimentArgument
from asmc_pin.cli.console import announce_compiling, print_json, say
from asmc_pin.cli.next_step import say_next
from asmc_pin.cli.options import JsonOption, per_joint
from asmc_pin.words.choices import RealType, Target


@app.command(rich_help_panel=ROBOT)
def export(
    experiment: ExperimentArgument,
    label: Annotated[str, typer.Argument(metavar="LABEL", help="One of its controllers.")],
    out: Annotated[str, typer.Option(metavar="DIR", help="Folder for the code.")],
    target: Annotated[
        Target, typer.Option(metavar="c|ros2_control", help="C alone, or a ros2_control controller around it too.")
    ] = "c",
    real: Annotated[RealType, typer.Option(metavar="double|float", help="Type of every number in C.")] = "double",
    certificate: Annotated[
        str | None,
        typer.Option(metavar="FILE", help="A proof about this arm and M̄; it is checked, and named in the code."),
    ] = None,
    torque_rate: Annotated[
        str | None,
        typer.Option(
            metavar="R1,R2,…", help="Torque-rate limit, N·m/s, inf for none; else [metrics] torque_rate_limit."
        ),
    ] = None,
    safe_torque: Annotated[str, typer.Option(metavar="T1,T2,…", help="Where a fault leads to, N·m.")] = "0",
    ramp: Annotated[float, typer.Option(metavar="S", help="From a fault to there.")] = 0.5,
    fault_ticks: Annotated[int, typer.Option(metavar="N", help="So many bad ticks in a row are a fault.")] = 5,
    force: Annotated[bool, typer.Option("--force", help="Replace an export that is there already.")] = False,
    as_json: JsonOption = False,
) -> None:
    """Write a controller as C99 within limits, with recorded vectors; where a compiler is there, it is run along them.

    The vectors are what Python computes, tick by tick; the C has to agree to the last bit. It runs the code of a law
    that the experiment names as 'my_module:MyLaw': do not export from a stranger's file unread.
    """
    unlimited = torque_rate is not None and torque_rate.strip() == "inf"
    rate = math.inf if unlimited else None if torque_rate is None else per_joint(torque_rate, "--torque-rate")
    safe = per_joint(safe_torque, "--safe-torque")
    from asmc_pin.experiment import load_experiment

    loaded = load_experiment(experiment)
    announce_compiling()
    from asmc_pin.codegen import export as run

    done = run(
        loaded,
        label,
        out,
        target=target,
        real=real,
        certificate=certificate,
        torque_rate=rate,
        safe_torque=safe,
        ramp=ramp,
        fault_ticks=fault_ticks,
        force=force,
    )
    if as_json:
        print_json(done.to_json_dict())
    else:
        say(*done.lines())
        say_next("the same ticks on the robot's own computer", done.check_yourself())
