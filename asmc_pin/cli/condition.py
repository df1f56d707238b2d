"""`asmc-pin verify`: is this M̄ allowed?"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from asmc_pin.cli.app import app
from asmc_pin.cli.options import (
    ArmArgument,
    ArmatureOption,
    BoxOption,
    ConditionOption,
    GravityOption,
    JsonOption,
    LockOption,
    MbarOption,
    PayloadOption,
    open_domain,
    parse_box,
    per_joint,
    print_json,
)

if TYPE_CHECKING:
    from asmc_pin.condition import ConditionReport

EXIT = {"holds": 0, "unrefuted": 0, "violated": 1, "undecided": 3}


@app.command()
def verify(
    arm: ArmArgument,
    mbar: MbarOption,
    condition: ConditionOption = "lemma1",
    samples: Annotated[int | None, typer.Option(min=1, help="Samples of the joint box.")] = None,
    seed: Annotated[int, typer.Option(min=0, help="Of the samples.")] = 0,
    along: Annotated[
        str | None,
        typer.Option(metavar="EXPERIMENT", help="Along this experiment's reference instead of over the joint box."),
    ] = None,
    box: BoxOption = None,
    payload: PayloadOption = None,
    armature: ArmatureOption = None,
    lock: LockOption = None,
    gravity: GravityOption = None,
    as_json: JsonOption = False,
) -> None:
    """Look for a configuration at which M̄ breaks the condition. Exit status 1 when there is one."""
    from asmc_pin.condition import verify as run

    loaded, domain = open_domain(arm, payload=payload, armature=armature, lock=lock, gravity=gravity)
    options: dict[str, Any] = {"condition": condition, "seed": seed, "box": parse_box(box), **domain}
    if samples is not None:
        options["samples"] = samples
    if along is not None:
        from asmc_pin.experiment import load_experiment

        options["along"] = load_experiment(along)
    report = run(loaded, per_joint(mbar, "--mbar"), **options)
    if as_json:
        print_json(report.to_json_dict())
    else:
        print_verdict(report)
    raise typer.Exit(EXIT[report.verdict])


def print_verdict(report: ConditionReport) -> None:
    """Print a report of the condition for a person to read; angles in degrees too."""
    import numpy as np
    from rich.console import Console
    from rich.table import Table

    console = Console(highlight=False)
    style = {"holds": "bold green", "unrefuted": "bold green", "violated": "bold red"}.get(
        report.verdict, "bold yellow"
    )
    console.print(f"{report.arm}: {report.formula}", soft_wrap=True)
    console.print(
        f"[{style}]{report.verdict}[/]  ({report.kind}, {report.configurations} configurations, {report.seconds:.1f} s)"
    )
    largest = f"largest norm found {report.lower:.6g}"
    if report.worst_time is not None:
        largest += f", at t = {report.worst_time:.4g} s"
    console.print(f"{largest}; smallest {report.smallest:.6g}")
    if report.worst_case:
        console.print(f"worst case: {report.worst_case}")
    table = Table("joint", "m̄ kg·m²", "worst q rad", "deg", box=None, pad_edge=False)
    for name, m, q in zip(report.joints, report.mbar, report.worst_q, strict=True):
        table.add_row(name, f"{m:.6g}", f"{q:+.6f}", f"{np.degrees(q):+.2f}")
    console.print(table)
    for line in report.notes:
        console.print(f"note: {line}", soft_wrap=True)


def report_path(text: str | None) -> Path | None:
    """``--report FILE``; the suffix chooses the form."""
    from asmc_pin.errors import ParameterError

    if text is None:
        return None
    path = Path(text)
    if path.suffix.lower() not in (".html", ".md"):
        raise ParameterError("--report", f"'{text}' ends in neither .html nor .md; the ending chooses the form")
    return path
