"""`asmc-pin identify`: how right a URDF is by a log of the robot, and what it leaves out."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import typer

from asmc_pin.cli.app import LISTS, app
from asmc_pin.cli.console import note, print_json, say
from asmc_pin.cli.loading_options import NOTHING, LoadingOptions, open_single, takes_loading_options
from asmc_pin.cli.options import ArmArgument, JsonOption, ReportOption, assignments, numbers
from asmc_pin.disk.files import check_readable, check_writable


@app.command(rich_help_panel=LISTS)
@takes_loading_options(without=("plant",))
def identify(
    arm: ArmArgument,
    log: Annotated[
        str,
        typer.Argument(metavar="LOG", help="CSV with , ; or tabs, also gzipped, or Parquet: t, q1 …, v1 …, tau1 …."),
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
    out: Annotated[
        str | None, typer.Option(metavar="FILE.toml", help="Write the measured plant, for --plant of other commands.")
    ] = None,
    report: ReportOption = None,
    loading: LoadingOptions = NOTHING,
    as_json: JsonOption = False,
) -> None:
    """Say how right a URDF is by a log of the robot; estimate friction, rotors, payload, torque constants and delay.

    Exit status 0: estimates were made; 1: the log contradicts the URDF, in a sign, an order, a unit or gravity.
    """
    from asmc_pin.logs.log_options import LogOptions

    check_readable(log, "the log")
    options = LogOptions(
        columns=assignments(columns, "--columns", "t|q|v|tau=NAME"),
        degrees=degrees,
        time_unit=time_unit,
        motor_constant=None if motor_constant is None else numbers(motor_constant, "--motor-constant"),
        torque_side=torque_side,
    )
    for path in (out, report):
        if path is not None and Path(path).parent.exists():  # else it is made
            check_writable(path)
    if report is not None:
        from asmc_pin.pages.plates import is_html

        is_html(Path(report))
    loaded = open_single(arm, loading)
    from asmc_pin.identification.identifying import identify as run

    found = run(loaded, log, options=options, cutoff_hz=cutoff_hz, fix=fix or ())
    if report is not None:
        from asmc_pin.pages.identified.identification_page import write_identification_page

        write_identification_page(found, report)
        note(f"page: {report}")
    if out is not None and not found.suspicions:
        from asmc_pin.disk.files import write_whole
        from asmc_pin.identification.plant_tables import plant_text

        write_whole(out, plant_text(found))
        note(f"measured plant: {out}")
    elif out is not None:
        note(f"nothing was estimated, so {out} was not written")
    if as_json:
        print_json(found.to_json_dict())
    else:
        say(*str(found).split("\n"))
    raise typer.Exit(1 if found.suspicions else 0)
