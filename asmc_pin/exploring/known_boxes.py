"""Joint boxes of which something is proven or refuted, for the explorer's map: cut anew, or read off a certificate."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from asmc_pin.condition.certificate.box_partition import OPEN, PROVEN, REFUTED, partition
from asmc_pin.condition.certificate.container import read
from asmc_pin.condition.certificate.walk import Record, in_joints
from asmc_pin.condition.checker import check
from asmc_pin.condition.checker.boxes.bisection import by_branch
from asmc_pin.condition.domain.arm_ranges import cases
from asmc_pin.condition.hypotheses import Hypotheses
from asmc_pin.errors import ParameterError
from asmc_pin.exploring.explored_arm import KnownBoxes
from asmc_pin.words.text import counted, printable, rounded_down

if TYPE_CHECKING:
    from asmc_pin.arms import Arm
    from asmc_pin.condition import ConditionReport

_ABOUT = ("joints", "mbar", "armature", "payload", "locked", "box", "scope", "condition")
"""Keys of the hypotheses that have to be the same; the URDF is compared as text."""

_MOST_BYTES = 2_000_000


def boxes_within(
    arm: Arm, report: ConditionReport, budget: float, progress: Callable[[str, float], None] | None
) -> KnownBoxes:
    """Prove and refute boxes of M̄ itself.

    Args:
        arm: The arm.
        report: What a search found for M̄.
        budget: For so long, s.
        progress: Called with what is being done and the share of the time.

    Raises:
        ParameterError: Joints of the arm mimic others, or the budget is no positive time.
    """
    if not budget > 0.0:
        raise ParameterError("budget", f"{budget!r} given, a positive time in s expected")

    def told(share: float) -> None:
        if progress is not None:
            progress("proving and refuting boxes", min(share, 1.0))

    case = cases(arm, report.box, None, None, None)[0]
    found = partition(case.domain, report.mbar, report.condition, budget=budget, known=report.worst_q, progress=told)
    proven, refuted, still_open = (found.boxes(mark) for mark in (PROVEN, REFUTED, OPEN))
    note = (
        f"The joint box was cut into {counted(proven + refuted + still_open, 'box', 'boxes')}: {proven} proven, "
        f"{refuted} with a configuration that violates the condition, {still_open} open."
    )
    if found.holds:
        note += " So the condition is proven over all of it."
    return KnownBoxes(found.records, 1.0, note, found.holds)


def boxes_of_certificate(
    arm: Arm, report: ConditionReport, path: Path, progress: Callable[[str, float], None] | None
) -> KnownBoxes:
    """The boxes of a certificate, checked first.

    Args:
        arm: The arm.
        report: What a search found for M̄.
        path: The certificate.
        progress: Called with what is being done and the share of it that is done.

    Raises:
        ParameterError: It is not valid, or about something else.
        ResultError: It cannot be read as a certificate.
    """
    container = read(path)
    name = printable(path.name)
    outcome = check(path, progress=progress)
    if not outcome.valid:
        raise ParameterError("certificate", f"{name} is not valid: {printable(outcome.problems[0])}")
    if not isinstance(outcome.hypotheses, Hypotheses):
        raise ParameterError("certificate", f"{name} is not about a condition on M̄")
    asked, told = report.hypotheses.to_json_dict(), outcome.hypotheses.to_json_dict()
    other = ["URDF"] if container.urdf != arm.urdf_text else [key for key in _ABOUT if asked[key] != told[key]]
    if other:
        raise ParameterError("certificate", f"{name} is about something else than what is asked: see its {other[0]}")
    if arm.mimics:
        raise ParameterError(
            "certificate", f"{name} is of joints that mimic others, whose boxes are not shown one by one"
        )
    of_scale = [
        (statement["scale"], number)
        for number, statement in enumerate(container.header["statements"])
        if statement["kind"] == report.condition and statement["level"] == 1.0
    ]
    if not of_scale:
        raise ParameterError("certificate", f"{name} proves no multiple of M̄")
    scale, number = max(of_scale)
    record = container.records[number]
    if record.size > _MOST_BYTES:
        raise ParameterError("certificate", f"{name} has {record.size} boxes, more than a page can show")
    records = tuple(_branches(record, arm))
    note = (
        f"{counted(int(np.count_nonzero(record == PROVEN)), 'box', 'boxes')} of the certificate {name}, checked before "
        f"this page was made: together they prove the condition for M̄ times {rounded_down(scale)} over the joint box."
    )
    return KnownBoxes(records, float(scale), note, scale >= 1.0)


def _branches(record: Record, arm: Arm) -> list[Record]:
    return [in_joints(part, joints) for joints, part in by_branch(record, arm.tree.parent)]
