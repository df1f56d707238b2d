"""`asmc-pin identify`: how right a URDF is by a log of the robot, and what it leaves out."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from asmc_pin.cli.app import LISTS, app
from asmc_pin.cli.console import announce_compiling, note, print_json, say
from asmc_pin.cli.next_step import again, say_next
from asmc_pin.cli.opening_arms import open_single
from asmc_pin.cli.option_groups.grouping import takes_option_groups
from asmc_pin.cli.option_groups.loading_options import NOTHING, LoadingOptions
from asmc_pin.cli.options import (
    ArmArgument,
    JsonOption,
    ReportOption,
    assignments,
    check_count,
    check_output,
    number,
    numbers,
    per_joint,
)
from asmc_pin.disk.file_access import check_readable
from asmc_pin.errors import ParameterError

if TYPE_CHECKING:
    from asmc_pin.identification.identification_report import Identification
    from asmc_pin.identification.mbar_along_log import MbarAlongLog
    from asmc_pin.log_rerun import LawOnLog


@app.command(rich_help_panel=LISTS)
@takes_option_groups(without=("plant",))
def identify(
    context: typer.Context,
    arm: ArmArgument,
    log: Annotated[
        str,
        typer.Argument(
            metavar="LOG",
            help="CSV with , ; or tabs, also gzipped, or Parquet: t, q1 …, v1 …, tau1 …. Or a ROS 2 bag.",
        ),
    ],
    columns: Annotated[
        list[str] | None,
        typer.Option(
            "--columns",
            metavar="t|q|v|tau=NAME",
            help="A column's name, or a pattern with {n} (joint from 1), {i} (from 0) or {joint} in it; '-' for none. "
            "Repeatable.",
        ),
    ] = None,
    degrees: Annotated[bool, typer.Option("--degrees", help="Angles and velocities are in degrees.")] = False,
    time_unit: Annotated[Literal["s", "ms", "us", "ns"], typer.Option(help="Unit of the time stamps.")] = "s",
    motor_constant: Annotated[
        str | None,
        typer.Option(metavar="K1,K2,…", help="N·m at the joint for each unit logged, such as A; one for all, or each."),
    ] = None,
    torque_side: Annotated[
        Literal["motor", "link"],
        typer.Option(help="Where the torque was measured; on the link's side the rotor is hidden."),
    ] = "motor",
    topic: Annotated[
        str | None, typer.Option(metavar="NAME", help="Topic of a bag, where several have sensor_msgs/JointState.")
    ] = None,
    cutoff_hz: Annotated[
        float | None, typer.Option(metavar="HZ", min=0.5, help="Low-pass of the angles; by their noise when omitted.")
    ] = None,
    fix: Annotated[
        list[str] | None,
        typer.Option(
            "--fix",
            metavar="GROUP",
            help="Do not estimate coulomb, viscous, stribeck, armature, payload, torque_constant, torque_offset or "
            "delay. Repeatable.",
        ),
    ] = None,
    mbar: Annotated[
        str | None,
        typer.Option(
            metavar="M1,M2,…",
            help="Say what this M̄ would have done: Lemma 1 and the TDE error along the log; kg·m², or one for all.",
        ),
    ] = None,
    period: Annotated[
        str | None, typer.Option(metavar="S", help="L of the TDE error; that of --law's experiment, or of the rows.")
    ] = None,
    law: Annotated[
        tuple[str, str] | None,
        typer.Option(
            "--law",
            metavar="EXPERIMENT LABEL",
            help="Run this controller on the arm as measured, along the log's motion, and compare torques.",
        ),
    ] = None,
    out: Annotated[
        str | None, typer.Option(metavar="FILE.toml", help="Write the measured plant, for --plant of other commands.")
    ] = None,
    report: ReportOption = None,
    loading: LoadingOptions = NOTHING,
    as_json: JsonOption = False,
) -> None:
    """Say how right a URDF is by a log of the robot; estimate friction, rotors, payload, torque constants and delay.

    With --mbar or --law also: what that M̄, or that controller, would have done along the log.

    Exit status 0: estimates were made; 1: the log contradicts the URDF, in a sign, an order, a unit or gravity.
    """
    from asmc_pin.logs.bag_table import is_bag
    from asmc_pin.logs.log_options import LogOptions

    if not is_bag(Path(log)):
        check_readable(log, "the log")
    options = LogOptions(
        columns=assignments(columns, "--columns", "t|q|v|tau=NAME"),
        degrees=degrees,
        time_unit=time_unit,
        motor_constant=None if motor_constant is None else numbers(motor_constant, "--motor-constant"),
        torque_side=torque_side,
        topic=topic,
    )
    for path in (out, report):
        check_output(path)
    if report is not None:
        from asmc_pin.pages.plates import is_html

        is_html(Path(report))
    if period is not None and mbar is None and law is None:
        raise ParameterError("--period", "is the L of a TDE error: add --mbar M1,M2,… or --law EXPERIMENT LABEL")
    values = None if mbar is None else per_joint(mbar, "--mbar")
    length = None if period is None else number(period, "--period")
    if law is not None:
        from asmc_pin.experiment.finding import find_experiment

        find_experiment(law[0])
    loaded = open_single(arm, loading)
    check_count(values, "--mbar", loaded)
    from asmc_pin.identification.identifying import identify as run

    found = run(loaded, log, options=options, cutoff_hz=cutoff_hz, fix=fix or ())
    along, ran = _hindsight(found, values, length, law)
    if report is not None:
        from asmc_pin.pages.identified.identification_page import write_identification_page

        write_identification_page(found, report, along=along, ran=ran)
        note(f"page: {report}")
    if out is not None and not found.suspicions:
        from asmc_pin.disk.files import write_whole
        from asmc_pin.identification.plant_file import plant_text

        write_whole(out, plant_text(found))
        note(f"measured plant: {out}")
    elif out is not None:
        note(f"nothing was estimated, so {out} was not written")
    if as_json:
        more = {key: each.to_json_dict() for key, each in (("mbar", along), ("law", ran)) if each is not None}
        print_json(found.to_json_dict() | more)
    else:
        for each in (found, along, ran):
            say(*([] if each is None else str(each).split("\n")))
        _say_next(context, found, log=log, out=out)
    raise typer.Exit(1 if found.suspicions else 0)


_ABOUT_THE_LOG = ("columns", "degrees", "time_unit", "motor_constant", "torque_side", "topic", "cutoff_hz", "fix")


def _say_next(context: typer.Context, found: Identification, *, log: str, out: str | None) -> None:
    """Mend the log's options where they mend it, else look into the URDF; use what was measured."""
    asked = (*_ABOUT_THE_LOG, "mbar", "period", "law", "out", "report")
    mending = found.suspicions[0].options if found.suspicions else ()
    if mending and not context.params[mending[0].removeprefix("--").replace("-", "_")]:
        say_next("the same with that put right", again(context, "identify", log, *mending, also=asked))
    elif found.suspicions:
        say_next("what the URDF says of each joint's axis", again(context, "inspect"))
    elif out is None:
        file = f"{Path(log).name.partition('.')[0]}_measured.toml"
        said = again(context, "identify", log, "--out", file, also=asked)
        say_next("the measured plant as a file that other commands take", said)
    else:
        # What the file has as well may not be said twice.
        own = {"payload": ("payload", "payload_com", "payload_inertia"), "armature": ("armature",)}
        measured = {name.partition(".")[0] for name in found.parameters} & set(own)
        said = again(context, "design", "--plant", out, without=[option for kind in measured for option in own[kind]])
        say_next("the M̄ that suits the arm as measured best", said)


def _hindsight(
    found: Identification, mbar: float | list[float] | None, period: float | None, law: tuple[str, str] | None
) -> tuple[MbarAlongLog | None, LawOnLog | None]:
    """What an M̄ and a law would have done, where one was asked for and the log does not contradict the URDF."""
    if found.suspicions:
        return None, None
    from asmc_pin.identification.mbar_along_log import mbar_on_log
    from asmc_pin.log_rerun import law_on_log

    ran: LawOnLog | None = None
    if law is not None:
        announce_compiling()
        ran = law_on_log(found, *law)
        period = ran.run.period if period is None else period
        if mbar is None and ran.mbar is not None:
            mbar = ran.mbar.tolist()
    return None if mbar is None else mbar_on_log(found, mbar, period=period), ran
