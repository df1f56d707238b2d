"""`asmc-pin design`: the best M̄, and the gains that a sampled loop with it bears."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from asmc_pin.cli.app import MBAR, app
from asmc_pin.cli.commands.condition_commands import EXIT, check_proof_options, prove, report_path, write_page
from asmc_pin.cli.console import note, print_json, progress_bar, say
from asmc_pin.cli.loading_options import NOTHING, LoadingOptions, open_domain, takes_loading_options
from asmc_pin.cli.loop_options import (
    AccelerationOption,
    DelayOption,
    FilterOption,
    SetOption,
    loop_proof_of,
    settings_of,
)
from asmc_pin.cli.next_step import SENSED, again, say_next
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
    number,
    parse_bounds,
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
from asmc_pin.disk.files import check_writable, write_whole
from asmc_pin.errors import ParameterError
from asmc_pin.words.choices import Form, Objective, Pairing, Velocity

if TYPE_CHECKING:
    from asmc_pin.arms import Arm
    from asmc_pin.condition import DesignReport
    from asmc_pin.sampled import StabilityReport
    from asmc_pin.sampled.gain_choice.gain_design import GainDesign


@app.command(rich_help_panel=MBAR)
@takes_loading_options()
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
    gains: Annotated[bool, typer.Option("--gains", help="Also β and K_s with margins; needs --period.")] = False,
    period: Annotated[str | None, typer.Option(metavar="S", help="Control period for --gains.")] = None,
    gain_margin: Annotated[float, typer.Option(help="Factor by which the torque gain may be off, for --gains.")] = 2.0,
    delay_margin: Annotated[float, typer.Option(help="Delay that may come on top, periods, for --gains.")] = 1.0,
    law: Annotated[
        str | None,
        typer.Option(metavar="dob|implicit", help="For --gains: the law to choose for, and what it is worth over ppc."),
    ] = None,
    settings: SetOption = None,
    coulomb: Annotated[
        str | None,
        typer.Option(metavar="C1,C2,…", help="Coulomb friction for the prediction, N·m; the URDF's if omitted."),
    ] = None,
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
    yaml: Annotated[
        str | None,
        typer.Option(
            metavar="FILE",
            help="For --gains: those of the PID that (7) is with backward differences, as ros2_control's parameters.",
        ),
    ] = None,
    noise_budget: Annotated[
        str | None,
        typer.Option(
            metavar="N1,N2,…",
            help="Torque RMS that noise may make, N·m per joint, for --gains: filter_hz is chosen too.",
        ),
    ] = None,
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
    if gains and period is None:
        raise ParameterError("--gains", "needs the control period: add --period 0.001, in seconds")
    if noise_budget is not None and not gains:
        raise ParameterError("--noise-budget", "is for gains: add --gains and --period")
    if (law is not None or settings) and not gains:
        raise ParameterError("--law" if law is not None else "--set", "is for gains: add --gains and --period")
    own = settings_of(law, settings)
    if yaml is not None:
        pairing, velocity = _of_a_pid(context, yaml, gains=gains, law=law)
    if law is not None:
        from asmc_pin.sampled.gain_choice.law_choice import checked_law

        checked_law(law)
    limits, ranges = parse_bounds(bounds), parse_box(box)
    allowed = None if noise_budget is None else per_joint(noise_budget, "--noise-budget")
    length = None if period is None else number(period, "--period")
    losses = None if coulomb is None else per_joint(coulomb, "--coulomb")
    if length is not None:
        from asmc_pin.words.units import check_period

        check_period(length, "--period")
        if yaml is not None:
            from asmc_pin.sampled.gain_choice.pid_parameters import update_rate

            update_rate(length)
    loaded, domain = open_domain(arm, loading)
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
    if allowed is not None and not sensor.noisy:
        raise ParameterError(
            "--noise-budget", "needs the noise: add --encoder-bits, --velocity-noise or --torque-noise"
        )
    from asmc_pin.condition import design as run

    options: dict[str, Any] = {"condition": condition, "objective": objective, "form": form, "level": level}
    with progress_bar(lines_every=2.0) as show:

        def tell(state: Any) -> None:
            said = f"looking for {state.doing}, program {state.rounds}"
            said += f", norm found {state.norm:.6g}" if state.norm < float("inf") else ""
            said += f", none is below {state.bound:.6g}" if state.bound > 0.0 else ""
            show(said, min(state.share, 1.0))

        found = run(loaded, **options, bounds=limits, box=ranges, seed=seed, budget=budget, progress=tell, **domain)
    if certify and found.check is not None:
        proof = {"gap": gap, "budget": budget, "seed": seed, "condition": condition, "box": ranges}
        file = _beside(certificate) if gains and certificate is not None else certificate
        check = prove(loaded, list(found.check.mbar), found.check, file, **proof, **domain)
        found = replace(found, check=check, verdict=check.verdict)
    write_page(found, loaded, page)
    content, lines, refuted = found.to_json_dict(), found.lines(), False
    if length is not None and gains and found.mbar is not None:
        from asmc_pin.sampled.gain_choice.gains import suggest_gains

        suggested = suggest_gains(
            loaded,
            found.mbar,
            length,
            acceleration=acceleration,
            filter_hz=filter_hz,
            delay=delay,
            sensor=sensor,
            pairing=pairing,
            noise_budget=allowed,
            gain_margin=gain_margin,
            delay_margin=delay_margin,
            coulomb=losses,
            pid=yaml is not None,
            law=law,
            settings=own,
            box=ranges,
            **domain,
        )
        if certify and suggested.report is not None:
            suggested = _with_proof(
                loaded, suggested, suggested.report, certificate, budget=budget, box=ranges, **domain
            )
            refuted = suggested.report is not None and not suggested.report.stable
        elif certificate is not None:
            note(f"no gains were found, so no certificate of them was written to {certificate}")
        content["gains"] = suggested.to_json_dict()
        if yaml is not None and suggested.report is not None:
            content["gains"]["pid"] |= _write_pid(loaded, suggested, yaml)
        elif yaml is not None:
            note(f"no gains were found, so {yaml} was not written")
        # One M̄ is printed, that of the gains.
        lines = [*found.lines(with_mbar=False), *suggested.lines()]
    if as_json:
        print_json(content)
    else:
        say(*lines)
        _say_next(context, found, gains=gains, certify=certify)
    raise typer.Exit(1 if refuted else {"infeasible": 1, **EXIT}[found.verdict])


def _say_next(context: typer.Context, found: DesignReport, *, gains: bool, certify: bool) -> None:
    kept = ("objective", "form", "bounds", "level", "seed")
    margins = ("period", "gain_margin", "delay_margin", "coulomb", "noise_budget", "law", "settings", *SENSED)
    more = () if certify else ("--certify",)
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


def _of_a_pid(context: typer.Context, yaml: str, *, gains: bool, law: str | None) -> tuple[Pairing, Velocity]:
    """The pairing and the velocity of a PID's loop, which are those that `--yaml` designs for.

    Raises:
        ParameterError: something else is asked for.
    """
    if not gains:
        raise ParameterError("--yaml", "is for gains: add --gains and --period")
    if law is not None:
        raise ParameterError(
            "--yaml", f"is of PPC's gains, which a PID can have, not of those of {law}; leave --law out"
        )
    for name, fitting in (
        ("velocity", "difference"),
        ("pairing", "last"),
        ("filter_hz", None),
        ("velocity_filter_hz", None),
    ):
        given, source = context.params.get(name), context.get_parameter_source(name)
        if source is not None and source.name == "COMMANDLINE" and given != fitting:
            option = f"--{name.replace('_', '-')}"
            raise ParameterError(
                option,
                f"{given} given, but a PID takes differences of angles and nothing is filtered in it; leave it out, or "
                "leave --yaml out",
            )
    check_writable(yaml)
    return "last", "difference"


def _write_pid(arm: Arm, design: GainDesign, yaml: str) -> dict[str, Any]:
    """Write the PID that gains are; p, i and d, for ``gains.pid``."""
    from asmc_pin.sampled.gain_choice.pid_parameters import pid_gains, pid_yaml

    write_whole(yaml, pid_yaml(design, arm))
    note(f"ros2_control parameters: {yaml}")
    return {**{name: values.tolist() for name, values in zip("pid", pid_gains(design), strict=True)}, "yaml": yaml}


def _beside(certificate: str) -> str:
    """Where the proof of M̄ goes when that of the gains goes to the file that was named."""
    file = Path(certificate)
    return str(file.with_name(f"{file.stem}-mbar{file.suffix}"))


def _with_proof(
    arm: Arm, design: GainDesign, report: StabilityReport, certificate: str | None, **options: Any
) -> GainDesign:
    """The same gains with what can be proven of their loop, if it is one that proofs are made for."""
    from asmc_pin.sampled.proof.loop_certificate import not_plain

    odd = not_plain(report.loop)
    if odd is not None:
        if certificate is not None:
            note(f"no proof is made for this loop ({': '.join(odd)}), so no certificate was written to {certificate}")
        return replace(design, unproven=": ".join(odd))
    return replace(design, report=replace(report, proof=loop_proof_of(arm, report.loop, certificate, **options)))
