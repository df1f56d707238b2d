"""`asmc-pin tune`: gains of every controller, searched with the same budget and judged held out."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Annotated

import typer

from asmc_pin.cli.app import STUDIES, app
from asmc_pin.cli.commands.study_commands import ExperimentArgument
from asmc_pin.cli.console import announce_compiling, print_json, progress_bar, say
from asmc_pin.cli.next_step import say_next
from asmc_pin.cli.options import JsonOption


@app.command(rich_help_panel=STUDIES)
def tune(
    experiment: ExperimentArgument,
    trials: Annotated[
        int, typer.Option(min=1, metavar="N", help="Candidates of each controller, the file's own gains among them.")
    ] = 64,
    out: Annotated[
        str | None, typer.Option(metavar="DIR", help="Where to write; results/NAME-tune when omitted.")
    ] = None,
    force: Annotated[
        bool, typer.Option("--force", help="Replace candidates of another experiment or version that lie there.")
    ] = False,
    report: Annotated[
        str | None, typer.Option(metavar="FILE", help="Write the page here too: .html, or .md with figures beside it.")
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Search gains for every controller with the same budget, and judge the best on draws that none was tuned on.

    Started again, it goes on where it was. It runs the code of a law that the experiment names as 'my_module:MyLaw':
    do not tune a stranger's file unread.
    """
    from asmc_pin.experiment import load_experiment

    loaded = load_experiment(experiment)
    if report is not None:
        from asmc_pin.disk.file_access import check_writable
        from asmc_pin.pages.plates import is_html

        is_html(Path(report))
        check_writable(report)
    announce_compiling()
    from asmc_pin.tuning import tune as run

    with progress_bar(lines_every=10.0, of="of the work") as progress:
        found = run(loaded, trials, out, force=force, progress=progress)
    if report is not None:
        from asmc_pin.pages.tunings.tune_figures import tune_plates
        from asmc_pin.pages.tunings.tune_page import page_of_tuning

        page_of_tuning(found.findings, list(tune_plates(found.findings))).write(report)
    if as_json:
        print_json(found.to_json_dict())
    else:
        say(*str(found).split("\n"))
        say_next("compare the tuned gains", shlex.join(["asmc-pin", "compare", str(found.path)]))
