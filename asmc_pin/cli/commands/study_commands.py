"""`asmc-pin compare`, `report`, `view` and `demo`: which controller is better, and what it looks like."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, TypeAlias

import typer

from asmc_pin.cli.app import PICTURES, STUDIES, app
from asmc_pin.cli.console import announce_compiling, note, print_json, progress_bar, rich_console, say
from asmc_pin.cli.next_step import say_next
from asmc_pin.cli.opening_arms import tell_doubts
from asmc_pin.cli.options import JsonOption
from asmc_pin.disk.file_access import check_writable
from asmc_pin.errors import ParameterError
from asmc_pin.words.text import visible

if TYPE_CHECKING:
    from asmc_pin.study import Comparison

DirArgument: TypeAlias = Annotated[
    str, typer.Argument(metavar="DIR", help="Folder of a result, or the name of one in results/.")
]
ExperimentArgument: TypeAlias = Annotated[
    str, typer.Argument(metavar="EXPERIMENT", help="A TOML file, or the name of a shipped experiment.")
]

MeasuredOption: TypeAlias = Annotated[
    str | None,
    typer.Option(
        "--plant", metavar="FILE", help="Lay the arm and plant that 'asmc-pin identify --out FILE' measured over it."
    ),
]


@app.command(rich_help_panel=STUDIES)
def compare(
    experiment: ExperimentArgument,
    out: Annotated[str | None, typer.Option(metavar="DIR", help="Where to write; results/NAME when omitted.")] = None,
    force: Annotated[bool, typer.Option("--force", help="Replace a result that is there already.")] = False,
    refine: Annotated[
        bool, typer.Option("--refine", help="Run again with half the step, and say how far each metric moves.")
    ] = False,
    plant: MeasuredOption = None,
    as_json: JsonOption = False,
) -> None:
    """Run every controller of an experiment on the same plant; write trajectories, tables, figures and a report.

    It runs the code of a law that the experiment names as 'my_module:MyLaw': do not compare a stranger's file unread.
    """
    from asmc_pin.experiment import load_experiment

    loaded = load_experiment(experiment, plant=plant)
    announce_compiling()
    from asmc_pin.study import compare as run

    tell_doubts(loaded.build_arm(), loaded.arm.source)
    with progress_bar() as progress:
        comparison = run(loaded, out=out, force=force, progress=progress, warn=warn, refine=refine)
    if as_json:
        print_json(comparison.to_json_dict())
    else:
        print_comparison(comparison)
        _say_next(comparison)


def _say_next(comparison: Comparison) -> None:
    from asmc_pin.pages.plain_words.after_comparison import after_comparison

    verdicts = {label: item.verdict for label, item in comparison.lemma1.items()}
    say_next(*after_comparison(comparison.experiment, verdicts, str(comparison.out)))


@app.command(rich_help_panel=STUDIES)
def report(directory: DirArgument) -> None:
    """Write report.html of a result anew."""
    from asmc_pin.results.result_folder import find_result, load_result

    find_result(directory)
    announce_compiling()
    from asmc_pin.pages.comparison_page import report_html

    result = load_result(directory)
    report_html(result, result.path / "report.html")
    say(f"report: {result.path / 'report.html'}")


@app.command(rich_help_panel=PICTURES)
def view(
    directory: DirArgument,
    html: Annotated[
        str | None, typer.Option(metavar="FILE", help="Write a page that opens offline, serve nothing.")
    ] = None,
    png: Annotated[
        str | None, typer.Option(metavar="FILE", help="Write a picture of the scene at --time, by a headless Chromium.")
    ] = None,
    time: Annotated[float, typer.Option(metavar="T", help="Of --png, s.")] = 0.0,
    mp4: Annotated[str | None, typer.Option(metavar="FILE", help="Write a film of all of it likewise.")] = None,
    follow: Annotated[
        bool, typer.Option("--follow", help="Serve a page that follows a running comparison or sweep.")
    ] = False,
    port: Annotated[int, typer.Option(min=0, max=65535, help="On 127.0.0.1; 0 takes a free one.")] = 0,
) -> None:
    """Replay a result in the browser, the controllers side by side. Served on 127.0.0.1 only; Ctrl-C ends it."""
    if follow:
        if html or png or mp4:
            raise ParameterError("--follow", "serves a page until Ctrl-C; leave --html, --png and --mp4 out")
        from asmc_pin.sweeping.watching.run_follower import follow as run_along

        run_along(directory, port)
        return
    from asmc_pin.results.result_folder import find_result

    find_result(directory)
    files = [file for file in (html, png, mp4) if file is not None]
    for option, file, ending in (("--png", png, ".png"), ("--mp4", mp4, ".mp4")):
        if file is not None and not file.lower().endswith(ending):
            raise ParameterError(option, f"'{file}' given, a name that ends in {ending} expected")
    for file in files:
        check_writable(file)
    announce_compiling()
    from asmc_pin.study.viewing import view as run

    if not files:
        run(directory, port=port)
        return
    with progress_bar(lines_every=5.0, of="of the film") as show:

        def tell(share: float) -> None:
            show("filming", share)

        run(directory, html=html, png=png, time=time, mp4=mp4, progress=tell)
    for file in files:
        size = Path(file).stat().st_size / 1e6
        say(f"{'replay' if file == html else 'picture' if file == png else 'film'}: {file} ({size:.1f} MB)")


@app.command(rich_help_panel=STUDIES)
def demo() -> None:
    """Verify an M̄ on the UR5, compare four controllers on it, and write results/demo with a report."""
    from asmc_pin.cli.condition_output import print_verdict
    from asmc_pin.condition import verify
    from asmc_pin.experiment import load_experiment
    from asmc_pin.study import compare as run

    announce_compiling()
    experiment = load_experiment("demo")
    arm = experiment.build_arm()
    tell_doubts(arm, experiment.arm.source)
    say("1. May this M̄ be used?")
    with progress_bar() as progress:
        progress("searching", 0.0)
        verdict = verify(arm, experiment.defaults["mbar"])
    print_verdict(verdict)
    say("", "2. Which controller is better?")
    with progress_bar() as progress:
        comparison = run(experiment, force=True, progress=progress, warn=warn)
    print_comparison(comparison)
    say_next("an experiment of your own", "asmc-pin new mine.toml --from demo")


def warn(line: str) -> None:
    """A warning on standard error, as soon as it is known."""
    note(f"warning: {line}")


def print_comparison(comparison: Comparison) -> None:
    """Print the table that a person reads first, what to know about it, and where the rest lies."""
    from rich.table import Table
    from rich.text import Text

    console = rich_console()
    overview = comparison.overview()
    header = list(map(visible, overview.header))
    # The range of a figure over the trials stands below it.
    rows = [
        [
            visible(cell) + ("\n" + "…".join(overview.ranges[i, j]) if (i, j) in overview.ranges else "")
            for j, cell in enumerate(row)
        ]
        for i, row in enumerate(overview.rows)
    ]
    columns = list(zip(*rows, strict=True))

    def width() -> int:
        cells = (
            [*head.split("\n"), *(line for cell in column for line in cell.split("\n"))]
            for head, column in zip(header, columns, strict=True)
        )
        return sum(max(map(len, column)) + 1 for column in cells)

    # Where the terminal is narrow, headings are broken at their spaces and underscores, and that of the labels goes, so
    # that seven joints fit 80 columns; a label or a figure is never cut.
    if width() > console.width:
        header = ["", *header[1:]]
        rows = [[cell.replace("…", "…\n") for cell in row] for row in rows]
        columns = list(zip(*rows, strict=True))
        header = [head.replace(" ", "\n").replace("_", "_\n") for head in header]
        console.width = max(console.width, width())
    table = Table(*header, title=overview.title, title_justify="left", box=None, pad_edge=False, collapse_padding=True)
    for column in table.columns[1:]:
        column.justify = "right"
    best = overview.marked()
    for i, row in enumerate(rows):
        table.add_row(*(Text(cell, style="bold" if (i, j) in best else "") for j, cell in enumerate(row)))
    console.print(table)
    for line in comparison.remarks():
        console.print(visible(line), soft_wrap=True)
