"""`asmc-pin inspect`: what was read of a URDF, and what is doubtful about it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from asmc_pin.cli.app import LISTS, app
from asmc_pin.cli.console import note, print_json, say
from asmc_pin.cli.next_step import again, say_next
from asmc_pin.cli.option_groups.grouping import takes_option_groups
from asmc_pin.cli.option_groups.loading_options import NOTHING, ONE_VALUE, LoadingOptions
from asmc_pin.cli.option_groups.loading_values import single_keywords
from asmc_pin.cli.options import ArmArgument, JsonOption, check_output

if TYPE_CHECKING:
    from asmc_pin.inspection.inspection_report import Inspection


@app.command(rich_help_panel=LISTS)
@takes_option_groups(instead=ONE_VALUE)
def inspect(
    context: typer.Context,
    arm: ArmArgument,
    html: Annotated[
        str | None,
        typer.Option(metavar="FILE", help="A 3-D page of the arm with inertia ellipsoids, centres of mass and axes."),
    ] = None,
    loading: LoadingOptions = NOTHING,
    as_json: JsonOption = False,
) -> None:
    """Say what is read of a URDF, joint by joint, and all that is doubtful about it, in one go.

    Exit status 0: other commands take it; 1: they refuse it, and the text says all that they refuse it for; 2: nothing
    of it can be told.
    """
    keywords = single_keywords(loading)
    check_output(html)
    from asmc_pin.inspection import inspect as run

    found = run(arm, **keywords)
    if html is not None and not found.refusal:
        found.write_page(html)
        note(f"page: {html}")
    elif html is not None:
        note(f"a refused arm is not drawn, so {html} was not written")
    if as_json:
        print_json(found.to_json_dict())
    else:
        say(*str(found).split("\n"))
        _say_next(context, found, drawn=html is not None)
    raise typer.Exit(1 if found.refusal else 0)


def _say_next(context: typer.Context, found: Inspection, *, drawn: bool) -> None:
    """Mend what is refused; look at what is doubtful; else go on to the question that an arm is loaded for."""
    if found.refusal and "--repair" in found.refusal and not context.params["repair"]:
        say_next("what a repair makes of it", again(context, "inspect", "--repair"))
    elif found.refusal:
        say_next("when that is mended", again(context, "inspect"))
    elif any(doubt.serious for doubt in found.doubts) and not drawn:
        page = f"{found.source.stem}.html"
        say_next("a picture of the bodies that are meant", again(context, "inspect", "--html", page))
    else:
        say_next("the M̄ that suits M(q) best", again(context, "design"))
