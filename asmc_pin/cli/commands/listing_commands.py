"""`asmc-pin arms` and `asmc-pin controllers`, and the rows that README.md shows too."""

from __future__ import annotations

from dataclasses import asdict
from typing import Annotated, Any

import typer

from asmc_pin.cli.app import LISTS, app
from asmc_pin.cli.console import print_json, rich_console, say
from asmc_pin.cli.options import JsonOption
from asmc_pin.errors import ParameterError
from asmc_pin.words.nearest_name import nearest

Rows = tuple[list[str], list[list[str]]]


def arm_rows() -> Rows:
    """Header and rows of the table of named arms."""
    from asmc_pin.arms import arms_table

    rows = arms_table()
    header = list(rows[0])
    return header, [[str(row[key]) for key in header] for row in rows]


def controller_rows() -> Rows:
    """Header and rows of the table of control laws; those that know the model come last and say so."""
    from asmc_pin.baselines import baselines_table
    from asmc_pin.controllers import controllers_table

    rows = controllers_table() + baselines_table()
    header = list(rows[0])
    return header, [[str(row[key]) for key in header] for row in rows]


def metric_rows() -> Rows:
    """Header and rows of the table of metrics."""
    from asmc_pin.metrics import METRICS

    header = ["metric", "unit", "definition"]
    return header, [[name, metric.unit, metric.formula] for name, metric in METRICS.items()]


def _print(title: str, table: Rows, as_json: bool, leave_out: tuple[str, ...] = ()) -> None:
    header, rows = table
    if as_json:
        print_json({title: [dict(zip(header, row, strict=True)) for row in rows]})
        return
    kept = [i for i, name in enumerate(header) if name not in leave_out]
    header, rows = [header[i] for i in kept], [[row[i] for i in kept] for row in rows]
    from rich.table import Table

    view = Table(*header, title=None, box=None, pad_edge=False)
    for column in view.columns:
        column.overflow = "fold"  # an equation may be broken, never cut
    for row in rows:
        view.add_row(*row)
    rich_console().print(view)


@app.command(rich_help_panel=LISTS)
def arms(as_json: JsonOption = False) -> None:
    """List the arms that have a name; --json and README.md also say where each comes from."""
    _print("arms", arm_rows(), as_json, leave_out=("origin", "licence"))


@app.command(rich_help_panel=LISTS)
def controllers(
    name: Annotated[
        str | None, typer.Argument(metavar="[NAME]", help="A law, to print its card: all of it on one page.")
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """List the control laws and their parameters; with a law's name, print its card and what a tick costs here."""
    if name is None:
        _print("controllers", controller_rows(), as_json)
        return
    from asmc_pin.baselines import BASELINES
    from asmc_pin.controllers import CONTROLLERS
    from asmc_pin.controllers.law_card import cost_per_tick, law_card, suggested

    law: Any
    if name in BASELINES:
        from asmc_pin.arms import load_arm
        from asmc_pin.baselines.model_card import ASKED, LIMITS, model_card, suggested_model_law

        arm = load_arm(ASKED)
        card, limits, law, joints = model_card(name), LIMITS, suggested_model_law(name, arm), arm.nv
    elif name in CONTROLLERS:
        from asmc_pin.sampled.stable_ratios import stable_words

        law, joints = suggested(CONTROLLERS[name]), 6
        card, limits = law_card(name, CONTROLLERS[name]), stable_words(law)
    else:
        known = [*CONTROLLERS, *BASELINES]
        raise ParameterError("NAME", f"there is no card of a law '{name}': {nearest(name, known)}")
    costs = {batch: 1e6 * cost_per_tick(law, batch, joints) for batch in (1, 256)}
    if as_json:
        figures = {str(batch): cost for batch, cost in costs.items()}
        print_json({**asdict(card), "limits": limits, "microseconds": figures})
        return
    said = " and ".join(f"{cost:.3g} µs at batch {batch}" for batch, cost in costs.items())
    say(
        *card.lines(),
        f"Limits: {limits}",
        f"Cost of a step per tick and trial of {joints} joints, here and now: {said}",
    )
