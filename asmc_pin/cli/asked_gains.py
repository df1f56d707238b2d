"""Gains that an option asks for beside M̄: what was said of them, what is found, proven and written."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import typer

from asmc_pin.cli.asked_proofs import loop_proof
from asmc_pin.cli.console import note
from asmc_pin.cli.option_groups.gain_options import GainOptions
from asmc_pin.cli.option_groups.law_options import settings_of
from asmc_pin.cli.option_groups.loop_options import LoopOptions
from asmc_pin.cli.options import check_count, number, per_joint
from asmc_pin.disk.file_access import check_writable
from asmc_pin.disk.files import write_whole
from asmc_pin.errors import ParameterError

if TYPE_CHECKING:
    from asmc_pin.arms import Arm
    from asmc_pin.sampled import LoopSensor, StabilityReport
    from asmc_pin.sampled.gain_choice.gain_design import GainDesign


@dataclass(frozen=True)
class AskedGains:
    """What was said of gains, read and checked.

    Attributes:
        period: Control period, s.
        loop: The loop that they are for.
        keywords: Further keywords of `suggest_gains`.
        yaml: Where the PID that they are goes to.
    """

    period: float
    loop: LoopOptions
    keywords: Mapping[str, Any]
    yaml: str | None

    def suggest(self, arm: Arm, mbar: Any, sensor: LoopSensor, **domain: Any) -> GainDesign:
        """Choose them for an M̄."""
        from asmc_pin.sampled.gain_choice.gains import suggest_gains

        return suggest_gains(arm, mbar, self.period, **self.loop.timing(), sensor=sensor, **self.keywords, **domain)

    def to_json_dict(self, found: GainDesign, arm: Arm) -> dict[str, Any]:
        """The key ``gains`` of ``design --json``; writes the PID where one was asked for."""
        content = found.to_json_dict()
        if self.yaml is not None and found.report is not None:
            content["pid"] |= _write_pid(arm, found, self.yaml)
        elif self.yaml is not None:
            note(f"no gains were found, so {self.yaml} was not written")
        return content


def asked_gains(context: typer.Context, given: GainOptions, loop: LoopOptions) -> AskedGains | None:
    """Read what was said of gains; None where none are asked for.

    Raises:
        ParameterError: a value cannot be used, or options do not go together.
    """
    if given.gains and given.period is None:
        raise ParameterError("--gains", "needs the control period: add --period 0.001, in seconds")
    if given.noise_budget is not None and not given.gains:
        raise ParameterError("--noise-budget", "is for gains: add --gains and --period")
    for option, said in (("--law", given.law), ("--set", given.settings), ("--period", given.period)):
        if said and not given.gains:
            raise ParameterError(option, f"is for gains: add --gains{' and --period' if option != '--period' else ''}")
    own = settings_of(given.law, given.settings)
    if given.yaml is not None:
        loop = _loop_of_a_pid(context, given, loop)
    if given.law is not None:
        from asmc_pin.sampled.gain_choice.law_choice import checked_law

        checked_law(given.law)
    budget = None if given.noise_budget is None else per_joint(given.noise_budget, "--noise-budget")
    period = None if given.period is None else number(given.period, "--period")
    coulomb = None if given.coulomb is None else per_joint(given.coulomb, "--coulomb")
    if period is not None:
        from asmc_pin.words.units import check_period

        check_period(period, "--period")
        from asmc_pin.sampled.gain_choice.gains import asked_margins

        asked_margins(given.gain_margin, given.delay_margin, period)
        if given.yaml is not None:
            from asmc_pin.sampled.gain_choice.pid_parameters import update_rate

            update_rate(period)
    if period is None or not given.gains:
        return None
    keywords = {
        "noise_budget": budget,
        "gain_margin": given.gain_margin,
        "delay_margin": given.delay_margin,
        "coulomb": coulomb,
        "pid": given.yaml is not None,
        "law": given.law,
        "settings": own,
    }
    return AskedGains(period, loop, keywords, given.yaml)


def check_values(asked: AskedGains | None, sensor: LoopSensor, arm: Arm) -> None:
    """Values are one for all joints or one for each, and a budget of noise needs a noise.

    Raises:
        ParameterError: there are too few or too many, or there is no noise.
    """
    if asked is None:
        return
    check_count(asked.keywords["coulomb"], "--coulomb", arm)
    if asked.keywords["coulomb"] is not None:
        from asmc_pin.sampled.noise.sensor_model import nonnegative_per_joint

        nonnegative_per_joint("coulomb", asked.keywords["coulomb"], arm.nv, "N·m")
    check_count(asked.keywords["noise_budget"], "--noise-budget", arm)
    if asked.keywords["noise_budget"] is not None and not sensor.noisy:
        raise ParameterError(
            "--noise-budget", "needs the noise: add --encoder-bits, --velocity-noise or --torque-noise"
        )


def with_proof(
    arm: Arm, design: GainDesign, report: StabilityReport, certificate: str | None, **options: Any
) -> GainDesign:
    """The same gains with what can be proven of their loop, if it is one that proofs are made for."""
    from asmc_pin.sampled.proof.loop_certificate import not_plain

    odd = not_plain(report.loop)
    if odd is not None:
        if certificate is not None:
            note(f"no proof is made for this loop ({': '.join(odd)}), so no certificate was written to {certificate}")
        return replace(design, unproven=": ".join(odd))
    return replace(design, report=replace(report, proof=loop_proof(arm, report.loop, certificate, **options)))


def _loop_of_a_pid(context: typer.Context, given: GainOptions, loop: LoopOptions) -> LoopOptions:
    """The loop of a PID, which is what `--yaml` designs for.

    Raises:
        ParameterError: something else is asked for.
    """
    if not given.gains:
        raise ParameterError("--yaml", "is for gains: add --gains and --period")
    if given.law is not None:
        raise ParameterError(
            "--yaml", f"is of PPC's gains, which a PID can have, not of those of {given.law}; leave --law out"
        )
    fitting = {"velocity": "difference", "pairing": "last", "filter_hz": None, "velocity_filter_hz": None}
    for name, value in fitting.items():
        source = context.get_parameter_source(name)
        said = getattr(loop, name)
        if source is not None and source.name == "COMMANDLINE" and said != value:
            raise ParameterError(
                f"--{name.replace('_', '-')}",
                f"{said} given, but a PID takes differences of angles and nothing is filtered in it; leave it out, or "
                "leave --yaml out",
            )
    check_writable(str(given.yaml))
    return replace(loop, velocity="difference", pairing="last")


def _write_pid(arm: Arm, design: GainDesign, yaml: str) -> dict[str, Any]:
    """Write the PID that gains are; p, i and d, for ``gains.pid``."""
    from asmc_pin.sampled.gain_choice.pid_parameters import pid_gains, pid_yaml

    write_whole(yaml, pid_yaml(design, arm))
    note(f"ros2_control parameters: {yaml}")
    return {**{name: values.tolist() for name, values in zip("pid", pid_gains(design), strict=True)}, "yaml": yaml}
