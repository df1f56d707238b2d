"""`asmc-pin bench`: every law on the arms and tasks of a suite, tuned with the same budget."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from asmc_pin.cli.app import STUDIES, app
from asmc_pin.cli.console import announce_compiling, print_json, progress_bar, say
from asmc_pin.cli.interrupt import stopping_short
from asmc_pin.cli.next_step import say_next
from asmc_pin.cli.options import JsonOption


@app.command(rich_help_panel=STUDIES)
def bench(
    suite: Annotated[
        str, typer.Argument(metavar="[SUITE]", help="A shipped suite, or a TOML file that extends one by laws.")
    ] = "asmc-bench-1",
    quick: Annotated[bool, typer.Option("--quick", help="A small part, to see that it runs; no result.")] = False,
    arm: Annotated[list[str] | None, typer.Option(metavar="NAME", help="Only this arm of it. Repeatable.")] = None,
    task: Annotated[list[str] | None, typer.Option(metavar="NAME", help="Only this task. Repeatable.")] = None,
    law: Annotated[list[str] | None, typer.Option(metavar="NAME", help="Only this law. Repeatable.")] = None,
    workers: Annotated[
        int | None, typer.Option(min=1, metavar="K", help="Processes; one for each processor when omitted.")
    ] = None,
    out: Annotated[
        str | None, typer.Option(metavar="DIR", help="Where to write; results/SUITE, or results/SUITE-part.")
    ] = None,
    report: Annotated[
        str | None, typer.Option(metavar="FILE", help="Write the page here too: .html, or .md with figures beside it.")
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Tune every law on several arms and tasks with the same budget, and rank them on draws that were held out.

    Started again, it goes on where it was. It runs the code of a law that the file names as 'my_module:MyLaw': do not
    run a stranger's file unread.
    """
    from asmc_pin.suites.suite_reading import load_suite

    load_suite(suite).part(quick=quick, arms=arm, tasks=task, laws=law)  # what is mistyped is said at once
    if report is not None:
        from asmc_pin.disk.file_access import check_writable
        from asmc_pin.pages.plates import is_html

        is_html(Path(report))
        check_writable(report)
    announce_compiling()
    from asmc_pin.suites import bench as run

    with progress_bar(lines_every=10.0, of="of the cells") as progress, stopping_short() as go_on:

        def tell(what: str, share: float) -> None:
            go_on()
            progress(what, share)

        found = run(suite, out, quick=quick, arms=arm, tasks=task, laws=law, workers=workers, progress=tell)
    if report is not None:
        from asmc_pin.pages.benches.bench_figures import bench_plates
        from asmc_pin.pages.benches.bench_page import page_of_bench

        page_of_bench(found.findings, list(bench_plates(found.findings))).write(report)
    if as_json:
        print_json(found.to_json_dict())
    else:
        say(*str(found).split("\n"))
        say_next("gains for an arm and a motion of your own", "asmc-pin new mine.toml --from ur5_tuning")
