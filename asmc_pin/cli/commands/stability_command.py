"""`asmc-pin stability`: whether a sampled loop is stable over the workspace, and what can be proven of it."""

from __future__ import annotations

import shlex
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated

import typer

from asmc_pin.cli.app import MBAR, app
from asmc_pin.cli.asked_proofs import check_proof_options, loop_proof
from asmc_pin.cli.console import note, print_json, say
from asmc_pin.cli.next_step import again, say_next
from asmc_pin.cli.opening_arms import open_domain
from asmc_pin.cli.option_groups.grouping import takes_option_groups
from asmc_pin.cli.option_groups.law_options import LawOption, SetOption, law_of
from asmc_pin.cli.option_groups.loading_options import NOTHING, LoadingOptions
from asmc_pin.cli.option_groups.loop_options import BARE_LOOP, LOOP_NAMES, LoopOptions
from asmc_pin.cli.options import (
    ArmArgument,
    BoxOption,
    BudgetOption,
    CertificateOption,
    CertifyOption,
    JsonOption,
    MbarOption,
    check_count,
    number,
    parse_box,
    per_joint,
    report_path,
)
from asmc_pin.disk.file_access import check_folder
from asmc_pin.errors import ParameterError

if TYPE_CHECKING:
    from asmc_pin.sampled import SampledLoop, StabilityReport


@app.command(rich_help_panel=MBAR)
@takes_option_groups()
def stability(
    context: typer.Context,
    arm: ArmArgument,
    mbar: MbarOption,
    ks: Annotated[str, typer.Option(metavar="K1,K2,…", help="Diagonal of K_s, 1/s, or one value for all joints.")],
    beta: Annotated[str, typer.Option(metavar="B", help="β, 1/s.")],
    period: Annotated[str, typer.Option(metavar="S", help="Control period L.")],
    law: LawOption = None,
    settings: SetOption = None,
    timing: LoopOptions = BARE_LOOP,
    box: BoxOption = None,
    loading: LoadingOptions = NOTHING,
    certify: CertifyOption = False,
    budget: BudgetOption = 60.0,
    certificate: CertificateOption = None,
    figures: Annotated[
        str | None,
        typer.Option(metavar="DIR", help="Draw the stable region, over β and k_s and over L, into this folder."),
    ] = None,
    report: Annotated[
        str | None,
        typer.Option("--report", metavar="FILE", help="Write a page: how slow may it run? .html or .md."),
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Analyse the sampled loop, frozen over the workspace. Exit status 1 when it is unstable somewhere.

    With --certify it is proven, without gravity, to be stable at every configuration of the box; 3: neither proven nor
    refuted within the budget.
    """
    check_proof_options(certify, certificate)
    page = report_path(report)
    if figures is not None:
        check_folder(figures, "--figures")
    values, slopes, ranges = per_joint(mbar, "--mbar"), per_joint(ks, "--ks"), parse_box(box)
    rate, length = number(beta, "--beta", "what may differ from joint to joint is --ks"), number(period, "--period")
    loaded, domain = open_domain(arm, loading)
    check_count(values, "--mbar", loaded)
    check_count(slopes, "--ks", loaded)
    sensor = timing.sensor(loaded.nv)
    # A law cannot see that the drives make v by difference; an experiment says so too.
    paired = timing.pairing
    if paired == "matched" and sensor.timing["velocity"] == "difference":
        paired = "mean"
    shared = {"mbar": values, "ks": slopes, "beta": rate, "period": length}
    filtered = {"acceleration": timing.acceleration, "filter_hz": timing.filter_hz, "pairing": paired}
    chosen = law_of(law, settings, **shared, **filtered)
    from asmc_pin.sampled import stability as run

    found = run(
        loaded, values, slopes, rate, length, **timing.timing(), sensor=sensor, law=chosen, box=ranges, **domain
    )
    if certify and chosen is not None:
        _refuse_proof(context, found.loop)
    if certify:
        found = replace(found, proof=loop_proof(loaded, found.loop, certificate, budget=budget, box=ranges, **domain))
    if figures is not None:
        from asmc_pin.pages.stability_figures import save_figures

        for path in save_figures(loaded, found.loop, figures, box=ranges):
            note(f"wrote {path}")
    if page is not None:
        from asmc_pin.pages.stability_page import write_stability_page
        from asmc_pin.sampled.frozen_arms import frozen_arms

        write_stability_page(found, frozen_arms(loaded, ranges, **domain), page, sensor=sensor)
        note(f"report: {page}")
    if as_json:
        print_json(found.to_json_dict())
    else:
        say(*found.lines())
        _say_next(context, found, law=law, certify=certify, budget=budget)
    open_question = found.proof is not None and found.proof.verdict == "undecided"
    raise typer.Exit(1 if not found.stable else 3 if open_question else 0)


def _say_next(context: typer.Context, found: StabilityReport, *, law: str | None, certify: bool, budget: float) -> None:
    from asmc_pin.sampled.proof.loop_certificate import not_plain

    asked = ("mbar", "ks", "beta", "period", "law", "settings", *LOOP_NAMES)
    if not found.stable and law is None:
        say_next("gains that this period bears", again(context, "design", "--gains", also=("period", *LOOP_NAMES)))
    elif not found.stable:
        say_next("what the law's parameters do", shlex.join(["asmc-pin", "controllers", str(law)]))
    elif found.proof is not None and found.proof.verdict == "undecided":
        longer = again(context, "stability", "--certify", "--budget", f"{2 * budget:g}", also=(*asked, "certificate"))
        say_next("twice the time", longer)
    elif not certify and not_plain(found.loop) is None:
        say_next("a proof", again(context, "stability", "--certify", also=asked))
    else:
        say_next("an experiment to put these gains into", "asmc-pin new mine.toml --from demo")


def _refuse_proof(context: typer.Context, loop: SampledLoop) -> None:
    """Say what can be proven of a law other than PPC, with the command that does it.

    Raises:
        ParameterError: Always; no proof is made of such a loop.
    """
    from asmc_pin.sampled.proof.loop_certificate import not_plain

    said = not_plain(loop)
    assert said is not None
    if not loop.law.estimates:
        raise ParameterError("--certify", said[1])
    condition_on = ",".join(f"{value:.10g}" for value in loop.tuned_law.estimate_weight * loop.mbar)
    command = again(context, "verify", "--mbar", condition_on, "--certify", also=("budget",))
    raise ParameterError("--certify", f"{said[1]}: {command}")
