"""`asmc-pin bounds`: how large M(q) is, proven over the joint box."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from asmc_pin.cli import interrupt
from asmc_pin.cli.app import MBAR, app
from asmc_pin.cli.commands.condition_commands import EXIT
from asmc_pin.cli.console import note, print_json, progress_bar, say
from asmc_pin.cli.loading_options import NOTHING, LoadingOptions, open_domain, takes_loading_options
from asmc_pin.cli.next_step import again, say_next
from asmc_pin.cli.options import (
    ArmArgument,
    BoxOption,
    BudgetOption,
    CertificateOption,
    GapOption,
    JsonOption,
    parse_box,
    per_joint,
)
from asmc_pin.disk.files import check_writable


@app.command(rich_help_panel=MBAR)
@takes_loading_options(without=("gravity",))
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
    if certificate is not None and Path(certificate).parent.exists():  # else it is made
        check_writable(certificate)
    loaded, domain = open_domain(arm, loading)
    from asmc_pin.condition import bounds as run

    with interrupt.stopping_short() as go_on, progress_bar() as show:

        def tell(state: Any) -> None:
            go_on()
            what = f"{state.trying}: found {state.refuted:.4g}, proven {state.proven:.4g}"
            show(what, min(state.seconds / (0.5 * budget), 1.0))

        report = run(loaded, scaling=scaling, gap=gap, budget=budget, box=ranges, seed=seed, progress=tell, **domain)
    if certificate is not None:
        from asmc_pin.condition.certificate.writing import unwritable

        if why := unwritable(report.cases):
            note(f"{why}; none was written to {certificate}")
        elif report.proofs:
            note(f"certificate: {report.save(certificate)}")
        else:
            note(f"nothing is proven, so no certificate was written to {certificate}")
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
