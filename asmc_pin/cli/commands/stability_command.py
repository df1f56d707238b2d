"""`asmc-pin stability`: whether a sampled loop is stable over the workspace, and what can be proven of it."""

from __future__ import annotations

import shlex
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated

import typer

from asmc_pin.cli.app import MBAR, app
from asmc_pin.cli.commands.condition_commands import check_proof_options, report_path
from asmc_pin.cli.console import note, print_json, say
from asmc_pin.cli.loading_options import NOTHING, LoadingOptions, open_domain, takes_loading_options
from asmc_pin.cli.loop_options import (
    AccelerationOption,
    DelayOption,
    FilterOption,
    LawOption,
    SetOption,
    law_of,
    loop_proof_of,
)
from asmc_pin.cli.next_step import SENSED, again, say_next
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
)
from asmc_pin.cli.sensor_options import (
    EncoderBitsOption,
    EncoderSideOption,
    GearOption,
    PairingOption,
    TorqueNoiseOption,
    VelocityFilterOption,
    VelocityNoiseOption,
    VelocityOption,
    sensor_of,
)
from asmc_pin.errors import ParameterError

if TYPE_CHECKING:
    from asmc_pin.sampled import SampledLoop, StabilityReport


@app.command(rich_help_panel=MBAR)
@takes_loading_options()
def stability(
    context: typer.Context,
    arm: ArmArgument,
    mbar: MbarOption,
    ks: Annotated[str, typer.Option(metavar="K1,K2,…", help="Diagonal of K_s, 1/s, or one value for all joints.")],
    beta: Annotated[str, typer.Option(metavar="B", help="β, 1/s.")],
    period: Annotated[str, typer.Option(metavar="S", help="Control period L.")],
    law: LawOption = None,
    settings: SetOption = None,
    acceleration: AccelerationOption = "velocity",
    filter_hz: FilterOption = None,
    delay: DelayOption = 0.0,
    velocity: VelocityOption = None,
    velocity_filter_hz: VelocityFilterOption = None,
    pairing: PairingOption = "matched",
    encoder_bits: EncoderBitsOption = None,
    encoder_side: EncoderSideOption = "joint",
    gear: GearOption = None,
    velocity_noise: VelocityNoiseOption = None,
    torque_noise: TorqueNoiseOption = None,
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
    values, slopes, ranges = per_joint(mbar, "--mbar"), per_joint(ks, "--ks"), parse_box(box)
    rate, length = number(beta, "--beta", "what may differ from joint to joint is --ks"), number(period, "--period")
    loaded, domain = open_domain(arm, loading)
    check_count(values, "--mbar", loaded)
    check_count(slopes, "--ks", loaded)
    sensor = sensor_of(
        loaded.nv,
        velocity=velocity,
        velocity_filter_hz=velocity_filter_hz,
        encoder_bits=encoder_bits,
        encoder_side=encoder_side,
        gear=gear,
        velocity_noise=velocity_noise,
        torque_noise=torque_noise,
    )
    # A law cannot see that the drives make v by difference; an experiment says so too.
    differs = sensor is not None and sensor.timing["velocity"] == "difference"
    paired = "mean" if pairing == "matched" and differs else pairing
    chosen = law_of(
        law,
        settings,
        mbar=values,
        ks=slopes,
        beta=rate,
        period=length,
        acceleration=acceleration,
        filter_hz=filter_hz,
        pairing=paired,
    )
    from asmc_pin.sampled import stability as run

    found = run(
        loaded,
        values,
        slopes,
        rate,
        length,
        acceleration=acceleration,
        filter_hz=filter_hz,
        delay=delay,
        sensor=sensor,
        pairing=pairing,
        law=chosen,
        box=ranges,
        **domain,
    )
    if certify and chosen is not None:
        _refuse_proof(context, found.loop)
    if certify:
        found = replace(
            found, proof=loop_proof_of(loaded, found.loop, certificate, budget=budget, box=ranges, **domain)
        )
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

    asked = ("mbar", "ks", "beta", "period", "law", "settings", *SENSED)
    if not found.stable and law is None:
        say_next("gains that this period bears", again(context, "design", "--gains", also=("period", *SENSED)))
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
