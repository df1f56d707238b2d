"""`asmc-pin sweep`: many trials that vary as [sweep] says."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Annotated

import typer

from asmc_pin.cli.app import STUDIES, app
from asmc_pin.cli.commands.study_commands import ExperimentArgument, MeasuredOption, print_comparison, warn
from asmc_pin.cli.console import announce_compiling, print_json, progress_bar, say
from asmc_pin.cli.interrupt import stopping_short
from asmc_pin.cli.next_step import say_next
from asmc_pin.cli.options import JsonOption


@app.command(rich_help_panel=STUDIES)
def sweep(
    experiment: ExperimentArgument,
    trials: Annotated[int, typer.Option(min=1, metavar="N", help="Draws at each point of the grids.")],
    workers: Annotated[
        int | None, typer.Option(min=1, metavar="K", help="Processes; one for each processor when omitted.")
    ] = None,
    dask: Annotated[
        str | None,
        typer.Option(
            metavar="ADDRESS", help="Run the blocks on this Dask cluster instead, such as tcp://10.0.0.1:8786."
        ),
    ] = None,
    block: Annotated[
        int | None,
        typer.Option(min=1, metavar="N", help="Trials that are run and written together; 32 when omitted."),
    ] = None,
    out: Annotated[
        str | None, typer.Option(metavar="DIR", help="Where to write; results/NAME-sweep when omitted.")
    ] = None,
    force: Annotated[
        bool, typer.Option("--force", help="Replace rows of another experiment, version or number of trials.")
    ] = False,
    replay: Annotated[
        int | None,
        typer.Option(min=0, metavar="TRIAL", help="Run this trial again, with everything logged and a page."),
    ] = None,
    report: Annotated[
        str | None, typer.Option(metavar="FILE", help="Write the page here too: .html, or .md with figures beside it.")
    ] = None,
    plant: MeasuredOption = None,
    as_json: JsonOption = False,
) -> None:
    """Run every controller in many trials that vary as its table 'sweep' says; started again, it goes on where it was.

    It runs the code of a law that the experiment names as 'my_module:MyLaw': do not sweep a stranger's file unread.
    """
    from asmc_pin.experiment import load_experiment

    loaded = load_experiment(experiment, plant=plant)
    if report is not None:
        from asmc_pin.disk.file_access import check_writable
        from asmc_pin.pages.plates import is_html

        is_html(Path(report))
        check_writable(report)
    announce_compiling()
    if replay is not None:
        from asmc_pin.sweeping.trial_replay import replay as run_again

        with progress_bar() as progress:
            comparison = run_again(loaded, trials, replay, out, progress=progress, warn=warn)
        if as_json:
            print_json(comparison.to_json_dict())
        else:
            print_comparison(comparison)
            say_next("watch the motion", shlex.join(["asmc-pin", "view", str(comparison.out)]))
        return
    from asmc_pin.sweeping import sweep as run

    # Workers are told to end, which takes an exception; what they have handed over is on the disk already.
    with progress_bar(lines_every=10.0, of="of the trials") as progress, stopping_short() as go_on:

        def tell(what: str, share: float) -> None:
            go_on()
            progress(what, share)

        found = run(loaded, trials, out, workers=workers, dask=dask, block=block, force=force, progress=tell)
    if report is not None:
        from asmc_pin.pages.sweeps.sweep_figures import sweep_plates
        from asmc_pin.pages.sweeps.sweep_page import page_of_sweep

        page_of_sweep(found.findings, list(sweep_plates(found.findings))).write(report)
    if as_json:
        print_json(found.to_json_dict())
    else:
        say(*str(found).split("\n"))
        words = ["asmc-pin", "sweep", experiment, "--trials", str(trials), "--replay", str(found.hardest)]
        given = [*(("--out", out) if out is not None else ()), *(("--plant", plant) if plant is not None else ())]
        failed = any(found.findings.failed.values())
        say_next(
            f"look at a trial {'that failed' if failed else 'with the largest error'}", shlex.join([*words, *given])
        )
