"""`asmc-pin bounds`: how large M(q) is, proven over the joint box."""

from __future__ import annotations

from typing import Annotated

import typer

from asmc_pin.cli.app import MBAR, app
from asmc_pin.cli.asked_proofs import inertia_proof
from asmc_pin.cli.condition_output import EXIT
from asmc_pin.cli.console import print_json, say
from asmc_pin.cli.next_step import again, say_next
from asmc_pin.cli.opening_arms import open_domain
from asmc_pin.cli.option_groups.grouping import takes_option_groups
from asmc_pin.cli.option_groups.loading_options import NOTHING, LoadingOptions
from asmc_pin.cli.options import (
    ArmArgument,
    BoxOption,
    BudgetOption,
    CertificateOption,
    GapOption,
    JsonOption,
    check_output,
    parse_box,
    per_joint,
)


@app.command(rich_help_panel=MBAR)
@takes_option_groups(without=("gravity",))
def bounds(
    context: typer.Context,
    arm: ArmArgument,
    scale: Annotated[
        str,
        typer.Option("--scale", metavar="S1,S2,…", help="Bound S M S in place of M: what each joint's velocity is in."),
    ] = "1",
    gap: GapOption = 0.01,
    budget: BudgetOption = 60.0,
    certificate: CertificateOption = None,
    seed: Annotated[int, typer.Option(min=0, help="Of the searches.")] = 0,
    box: BoxOption = None,
    loading: LoadingOptions = NOTHING,
    as_json: JsonOption = False,
) -> None:
    """Prove m₁ I ≺ M(q) ≺ m₂ I over the joint box, and bounds of its condition number and of C(q, q̇)q̇ by ‖q̇‖².

    Exit status 0: m₁ and m₂ are proven; 3: one of them is not, within the budget.
    """
    scaling, ranges = per_joint(scale, "--scale"), parse_box(box)
    check_output(certificate)
    loaded, domain = open_domain(arm, loading)
    options = {"gap": gap, "budget": budget, "box": ranges, "seed": seed, **domain}
    report = inertia_proof(loaded, certificate, scaling=scaling, **options)
    if as_json:
        print_json(report.to_json_dict())
    else:
        say(*str(report).split("\n"))
        _say_next(context, report.verdict, budget)
    raise typer.Exit(EXIT[report.verdict])


def _say_next(context: typer.Context, verdict: str, budget: float) -> None:
    if verdict == "undecided":
        longer = again(context, "bounds", "--budget", f"{2 * budget:g}", also=("scale", "gap", "seed", "certificate"))
        say_next("twice the time", longer)
    else:
        say_next("the M̄ that suits M(q) best", again(context, "design"))
