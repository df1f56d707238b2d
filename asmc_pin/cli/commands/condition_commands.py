"""`asmc-pin verify`: is this M̄ allowed?"""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

import typer

from asmc_pin.cli.app import MBAR, app
from asmc_pin.cli.asked_proofs import check_proof_options, condition_proof
from asmc_pin.cli.condition_output import EXIT, print_verdict, write_page
from asmc_pin.cli.console import print_json, say
from asmc_pin.cli.low_passed_condition import low_passed_conditions
from asmc_pin.cli.next_step import again, say_next
from asmc_pin.cli.opening_arms import open_domain
from asmc_pin.cli.option_groups.grouping import takes_option_groups
from asmc_pin.cli.option_groups.loading_options import NOTHING, LoadingOptions
from asmc_pin.cli.options import (
    ArmArgument,
    BoxOption,
    BudgetOption,
    CertificateOption,
    CertifyOption,
    ConditionOption,
    GapOption,
    JsonOption,
    MbarOption,
    ReportOption,
    check_count,
    parse_box,
    per_joint,
    report_path,
)
from asmc_pin.disk.file_access import check_readable
from asmc_pin.errors import ParameterError

if TYPE_CHECKING:
    from asmc_pin.arms import Arm

RECORDINGS = (".csv", ".csv.gz", ".parquet")
"""Endings of recorded data."""


@app.command(rich_help_panel=MBAR)
@takes_option_groups()
def verify(
    context: typer.Context,
    arm: ArmArgument,
    mbar: MbarOption,
    condition: ConditionOption = "lemma1",
    samples: Annotated[int | None, typer.Option(min=1, help="Samples of the joint box.")] = None,
    seed: Annotated[int, typer.Option(min=0, help="Of the samples.")] = 0,
    along: Annotated[
        str | None,
        typer.Option(metavar="EXPERIMENT", help="Along this experiment's reference instead of over the joint box."),
    ] = None,
    tube: Annotated[
        float | None, typer.Option(metavar="RAD", help="With --along: also all within this of the motion, rad or m.")
    ] = None,
    certify: CertifyOption = False,
    gap: GapOption = 0.01,
    budget: BudgetOption = 60.0,
    certificate: CertificateOption = None,
    report: ReportOption = None,
    box: BoxOption = None,
    loading: LoadingOptions = NOTHING,
    as_json: JsonOption = False,
) -> None:
    """Look for a configuration at which M̄ breaks the condition, or prove that there is none.

    Exit status 0: it holds, or was not refuted; 1: it is violated; 3: undecided within the budget.
    """
    page = report_path(report)
    check_proof_options(certify, certificate)
    if certify and along is not None and tube is None:
        raise ParameterError("--certify", "proves over boxes: add --tube RAD for a tube around the motion")
    if tube is not None and along is None:
        raise ParameterError("--tube", "is around a motion: add --along EXPERIMENT or a CSV of recorded data")
    values, ranges = per_joint(mbar, "--mbar"), parse_box(box)
    _check_along(along)
    loaded, domain = open_domain(arm, loading)
    check_count(values, "--mbar", loaded)
    seen = along is None and not domain
    from asmc_pin.condition import verify as run

    domain |= {"condition": condition, "seed": seed, "box": ranges}
    options: dict[str, Any] = {} if samples is None else {"samples": samples}
    if along is not None:
        options |= {"along": _motion(along, loaded), "tube_width": tube}
    found = run(loaded, values, **domain, **options)
    low_passed = low_passed_conditions(options.get("along"), loaded, **domain, **options)
    if certify:
        options.pop("samples", None)
        found = condition_proof(loaded, values, found, certificate, gap=gap, budget=budget, **domain, **options)
    if as_json:
        others = {item.label: item.to_json_dict() for item in low_passed}
        print_json(found.to_json_dict() | ({"low_passed": others} if others else {}))
    else:
        print_verdict(found)
        for item in low_passed:
            say(item.line())
        _print_tde_error(options.get("along"), loaded, values)
        _say_next(context, found.verdict, proves=along is None or tube is not None, seen=seen, budget=budget)
    write_page(found, loaded, page)  # last: a full disk takes nothing of what was found
    raise typer.Exit(EXIT[found.verdict])


def _say_next(context: typer.Context, verdict: str, *, proves: bool, seen: bool, budget: float) -> None:
    """The next command; `seen`: the statement is one that `explore` shows, about one arm over the joint box."""
    question = ("mbar", "along", "tube", "seed")
    if verdict in ("violated", "undecided") and seen:
        say_next("a page that shows where", again(context, "explore", "--certify", also=("mbar", "seed")))
    if verdict == "violated":
        say_next("an M̄ that suits M(q)", again(context, "design"))
    elif verdict == "unrefuted" and proves:
        say_next("a proof", again(context, "verify", "--certify", also=question))
    elif verdict == "unrefuted":
        about = again(context, "verify", "--tube", "0.05", "--certify", also=("mbar", "along", "seed"))
        say_next("a proof, which needs room around the motion, here 0.05 rad", about)
    elif verdict == "undecided":
        longer = again(
            context, "verify", "--certify", "--budget", f"{2 * budget:g}", also=(*question, "gap", "certificate")
        )
        say_next("twice the time", longer)
    elif verdict == "holds":
        say_next(
            "gains that a sampled loop bears, here at 1 ms", again(context, "design", "--gains", "--period", "0.001")
        )


def _check_along(along: str | None) -> None:
    """Say that ``--along`` is neither a file nor an experiment before anything is loaded for it."""
    if along is None:
        return
    if along.lower().endswith(RECORDINGS):
        check_readable(along, "the recorded motion")
        return
    from asmc_pin.experiment.finding import find_experiment

    find_experiment(along)


def _motion(along: str, arm: Arm) -> Any:
    """An experiment, of which the motion alone is wanted, or recorded data where the name ends as those do."""
    if along.lower().endswith(RECORDINGS):
        from asmc_pin.condition.domain.recorded_motion import read_recording

        return read_recording(along, arm)
    from asmc_pin.experiment import load_experiment

    return load_experiment(along, import_laws=False)


def _print_tde_error(along: Any, arm: Arm, mbar: float | list[float]) -> None:
    """The TDE error that M̄ would have made along recorded motion, where its torque was recorded too."""
    from asmc_pin.condition.domain.recorded_motion import Recording, tde_error

    if not isinstance(along, Recording) or along.torque is None:
        return
    import numpy as np

    error = np.nanmax(np.abs(tde_error(arm, mbar, along)), axis=0)
    figures = ", ".join(f"{name} {value:.4g}" for name, value in zip(arm.joint_names, error, strict=True))
    say(f"largest TDE error |N| that M̄ would have made, rad/s²: {figures}")
