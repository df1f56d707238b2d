"""`asmc-pin explore`: a page on which joints, M̄ and gains are moved."""

from __future__ import annotations

from typing import Annotated, Any

import typer

from asmc_pin.cli.app import PICTURES, app
from asmc_pin.cli.console import progress_bar, say
from asmc_pin.cli.opening_arms import open_single
from asmc_pin.cli.option_groups.grouping import takes_option_groups
from asmc_pin.cli.option_groups.loading_options import NOTHING, ONE_VALUE, LoadingOptions
from asmc_pin.cli.options import (
    ArmArgument,
    BoxOption,
    BudgetOption,
    CertifyOption,
    ConditionOption,
    MbarOption,
    check_count,
    check_output,
    parse_box,
    per_joint,
)
from asmc_pin.disk.file_access import check_readable
from asmc_pin.errors import ParameterError


@app.command(rich_help_panel=PICTURES)
@takes_option_groups(instead=ONE_VALUE)
def explore(
    arm: ArmArgument,
    mbar: MbarOption,
    html: Annotated[
        str | None, typer.Option(metavar="FILE", help="Write a page that opens offline, serve nothing.")
    ] = None,
    port: Annotated[int, typer.Option(min=0, max=65535, help="On 127.0.0.1; 0 takes a free one.")] = 0,
    condition: ConditionOption = "lemma1",
    ks: Annotated[float, typer.Option("--ks", help="k_s of the sampled loop at first, 1/s.")] = 10.0,
    beta: Annotated[float, typer.Option("--beta", help="Its β, 1/s.")] = 10.0,
    period: Annotated[float, typer.Option("--period", help="Its period L, s.")] = 0.001,
    certify: CertifyOption = False,
    budget: BudgetOption = 20.0,
    certificate: Annotated[
        str | None,
        typer.Option("--certificate", metavar="FILE", help="Show the boxes of this certificate, checked first."),
    ] = None,
    samples: Annotated[int | None, typer.Option(min=1, help="Samples of the joint box.")] = None,
    seed: Annotated[int, typer.Option(min=0, help="Of the samples.")] = 0,
    box: BoxOption = None,
    loading: LoadingOptions = NOTHING,
) -> None:
    """Move joints and M̄ on a page: norm, worst direction, stable gains and a map follow at once.

    --certify cuts the joint box into boxes in which the condition is proven or violated, for as long as --budget says;
    the map shows those that it meets. Served on 127.0.0.1 only, it also says whether links collide; Ctrl-C ends it.
    """
    if certify and certificate is not None:
        raise ParameterError("--certificate", "has boxes of its own: leave --certify out")
    if certificate is not None:
        check_readable(certificate, "the certificate")
    check_output(html)
    values, ranges = per_joint(mbar, "--mbar"), parse_box(box)
    loaded = open_single(arm, loading)
    check_count(values, "--mbar", loaded)
    from asmc_pin.exploring.exploring_verb import checked_gains, look

    gains = checked_gains(ks, beta, period)
    options: dict[str, Any] = {} if samples is None else {"samples": samples}
    proof: dict[str, Any] = {"budget": budget if certify else None, "certificate": certificate}
    with progress_bar() as show:
        explored = look(loaded, values, condition=condition, box=ranges, seed=seed, progress=show, **proof, **options)
    if html is None:
        explored.serve(gains, port)
        return
    page = explored.write(html, gains)
    say(f"explorer: {page} ({page.stat().st_size / 1e6:.1f} MB)")
