"""A search and a proof of the same statement, in one report."""

from __future__ import annotations

from dataclasses import fields, replace
from typing import TYPE_CHECKING

from asmc_pin.condition.condition_report import ConditionReport
from asmc_pin.condition.hypotheses import Hypotheses
from asmc_pin.errors import ParameterError
from asmc_pin.words.text import counted

if TYPE_CHECKING:
    from asmc_pin.condition.certificate.certificate_result import CertificateResult


def certified(report: ConditionReport, result: CertificateResult) -> ConditionReport:
    """Join what a search and a proof say about the same question.

    Args:
        report: Of `verify` over a joint box, or in a tube.
        result: Of `certify`, for the same arm, M̄, condition, box or tube, and ranges.

    Returns:
        The report with kind ``certified``: bounds, scales and verdict of the proof, and the worst configuration that
        either has seen. A counter-example outweighs everything.

    Raises:
        ParameterError: They speak of different things.
    """
    # All of the statement has to agree: a proof with more armature, say, is of another arm.
    if differing := [
        item.name
        for item in fields(Hypotheses)
        if getattr(report.hypotheses, item.name) != getattr(result.hypotheses, item.name)
    ]:
        raise ParameterError(
            "result",
            "the proof and the search are not of the same arm, M̄, condition and domain: they differ in "
            f"{', '.join(differing)}",
        )
    searched = report.lower >= result.lower
    lower = max(report.lower, result.lower)
    verdict, refuted = result.verdict, result.scale_refuted
    if lower >= 1.0:
        verdict, refuted = "violated", min(refuted, 1.0)
    sampled = "sampled and searched, not proven"
    subject = report.subject if searched else result.cases[result.worst_index].domain.arm
    return replace(
        report,
        kind="certified",
        verdict=verdict,
        lower=lower,
        upper=None if verdict == "violated" else result.upper,
        scale_proven=result.scale_proven,
        scale_refuted=refuted,
        reason=result.reason,
        worst_q=report.worst_q if searched else result.worst_q,
        worst_armature=report.worst_armature if searched else result.worst_armature,
        worst_case=report.worst_case if searched else result.worst_case,
        worst_time=report.worst_time if searched else None,
        subject=subject,
        configurations=report.configurations + result.tests,
        seconds=report.seconds + result.seconds,
        notes=(*(note for note in report.notes if not note.startswith(sampled)), *_new(report, result)),
        method=(
            *report.method,
            f"proof by bounds over {counted(result.boxes, 'box', 'boxes')}, {result.tests} tested, in floating point "
            f"with enclosed errors; it stopped because: {result.reason}",
        ),
    )


def _new(report: ConditionReport, result: CertificateResult) -> list[str]:
    """Notes of the proof that the search has not made in other words."""
    return [note for note in result.notes if not any(note[:24] == known[:24] for known in report.notes)]
