"""`asmc-pin design`: the best M̄, and the gains that a sampled loop with it bears."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from asmc_pin.cli.app import MBAR, app
from asmc_pin.cli.asked_gains import asked_gains, check_values, with_proof
from asmc_pin.cli.asked_proofs import check_proof_options, condition_proof
from asmc_pin.cli.condition_output import EXIT, write_page
from asmc_pin.cli.console import note, print_json, progress_bar, say
from asmc_pin.cli.next_step import again, say_next
from asmc_pin.cli.opening_arms import open_domain
from asmc_pin.cli.option_groups.gain_options import NO_GAINS, GainOptions
from asmc_pin.cli.option_groups.grouping import takes_option_groups
from asmc_pin.cli.option_groups.loading_options import NOTHING, LoadingOptions
from asmc_pin.cli.option_groups.loop_options import BARE_LOOP, LOOP_NAMES, LoopOptions
from asmc_pin.cli.options import (
    ArmArgument,
    BoxOption,
    BudgetOption,
    CertificateOption,
    CertifyOption,
    ConditionOption,
    GapOption,
    JsonOption,
    ReportOption,
    parse_bounds,
    parse_box,
    report_path,
)
from asmc_pin.words.choices import Form, Objective

if TYPE_CHECKING:
    from asmc_pin.condition import DesignReport


@app.command(rich_help_panel=MBAR)
@takes_option_groups()
def design(
    context: typer.Context,
    arm: ArmArgument,
    condition: ConditionOption = "lemma1",
    objective: Annotated[
        Objective,
        typer.Option(
            metavar="contraction|bandwidth", help="Least norm, or the fastest estimate that the condition allows."
        ),
    ] = "contraction",
    form: Annotated[Form, typer.Option(metavar="diagonal|scalar", help="One m̄ per joint, or one.")] = "diagonal",
    bounds: Annotated[
        list[str] | None,
        typer.Option(metavar="JOINT=LO:HI", help="Least and largest m̄ of a joint, kg·m². Repeatable."),
    ] = None,
    level: Annotated[float | None, typer.Option(help="Largest norm that the bandwidth objective may use.")] = None,
    gain: GainOptions = NO_GAINS,
    loop: LoopOptions = BARE_LOOP,
    seed: Annotated[int, typer.Option(min=0, help="Of the searches.")] = 0,
    certify: CertifyOption = False,
    gap: GapOption = 0.01,
    budget: BudgetOption = 60.0,
    certificate: CertificateOption = None,
    report: ReportOption = None,
    box: BoxOption = None,
    loading: LoadingOptions = NOTHING,
    as_json: JsonOption = False,
) -> None:
    """Find the M̄ of least contraction, or of the fastest estimate. Exit status 1 when none satisfies the condition.

    With --yaml the gains are designed for that PID's own loop, velocity by difference and the last torque.

    With --gains --certify it is also said what is proven of the gains' loop; 1 too where that refutes what a search
    found stable. --certificate then writes that proof to FILE, and the one of M̄ beside it, to FILE with -mbar in its
    name. Sensor options count for --gains.
    """
    page = report_path(report)
    check_proof_options(certify, certificate)
    asked = asked_gains(context, gain, loop)
    limits, ranges = parse_bounds(bounds), parse_box(box)
    loaded, domain = open_domain(arm, loading)
    sensor = (loop if asked is None else asked.loop).sensor(loaded.nv)
    check_values(asked, sensor, loaded)
    options = {"condition": condition, "objective": objective, "form": form, "level": level, "bounds": limits}
    found = _designed(loaded, **options, box=ranges, seed=seed, budget=budget, **domain)
    if certify and found.check is not None:
        wanted = {"gap": gap, "budget": budget, "seed": seed, "condition": condition, "box": ranges}
        file = _beside(certificate) if asked is not None and certificate is not None else certificate
        check = condition_proof(loaded, list(found.check.mbar), found.check, file, **wanted, **domain)
        found = replace(found, check=check, verdict=check.verdict)
    content, lines, refuted, open_question = found.to_json_dict(), found.lines(), False, False
    if asked is not None and found.mbar is not None:
        suggested = asked.suggest(loaded, found.mbar, sensor, box=ranges, **domain)
        if certify and suggested.report is not None:
            suggested = with_proof(
                loaded, suggested, suggested.report, certificate, budget=budget, box=ranges, **domain
            )
            refuted = suggested.report is not None and not suggested.report.stable
            proof = None if suggested.report is None else suggested.report.proof
            open_question = proof is not None and proof.verdict == "undecided"
        elif certificate is not None:
            note(f"no gains were found, so no certificate of them was written to {certificate}")
        content["gains"] = asked.to_json_dict(suggested, loaded)
        # One M̄ is printed, that of the gains.
        lines = [*found.lines(with_mbar=False), *suggested.lines()]
    if as_json:
        print_json(content)
    else:
        say(*lines)
        short = found.verdict == "undecided" or open_question or bool(found.unfinished and found.seconds >= budget)
        _say_next(context, found, gains=gain.gains, certify=certify, longer=2.0 * budget if short else None)
    write_page(found, loaded, page)  # last: a full disk takes nothing of what was found
    raise typer.Exit(1 if refuted else {"infeasible": 1, **EXIT}[found.verdict])


def _designed(arm: Any, **options: Any) -> DesignReport:
    """Run the design with a line now and then of how far it is."""
    from asmc_pin.condition import design as run

    with progress_bar(lines_every=2.0) as show:

        def tell(state: Any) -> None:
            said = f"looking for {state.doing}, program {state.rounds}"
            said += f", norm found {state.norm:.6g}" if state.norm < float("inf") else ""
            said += f", none is below {state.bound:.6g}" if state.bound > 0.0 else ""
            show(said, min(state.share, 1.0))

        return run(arm, **options, progress=tell)


def _say_next(context: typer.Context, found: DesignReport, *, gains: bool, certify: bool, longer: float | None) -> None:
    """The next command; `longer`: a budget, s, where this one was up before all was done."""
    kept = ("objective", "form", "bounds", "level", "seed")
    margins = ("period", "gain_margin", "delay_margin", "coulomb", "noise_budget", "law", "settings", *LOOP_NAMES)
    more = () if certify else ("--certify",)
    if longer is not None:
        asked = (*kept, *margins, "gains", "yaml", "certify", "gap", "certificate", "report")
        say_next("twice the time", again(context, "design", "--budget", f"{longer:g}", also=asked))
    if found.mbar is None:
        say_next("how large M(q) is, which M̄ has to suit", again(context, "bounds"))
    elif not gains:
        say_next(
            "gains for it, here at 1 ms", again(context, "design", "--gains", "--period", "0.001", *more, also=kept)
        )
    elif not certify and not context.params.get("yaml"):  # no proof covers a PID's own map
        say_next("what can be proven of them", again(context, "design", "--gains", "--certify", also=(*kept, *margins)))
    else:
        say_next("an experiment to put them into", "asmc-pin new mine.toml --from demo")


def _beside(certificate: str) -> str:
    """Where the proof of M̄ goes when that of the gains goes to the file that was named."""
    file = Path(certificate)
    return str(file.with_name(f"{file.stem}-mbar{file.suffix}"))
