"""What a certificate speaks of: the joint box, or a tube around a motion, for every arm of the ranges."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from asmc_pin._typing import Array
from asmc_pin.condition.domain.along_motion import check_units, motion_of, tube
from asmc_pin.condition.domain.arm_ranges import ArmatureRange, Case, LockChoices, PayloadRange, cases
from asmc_pin.condition.domain.joint_box import BoxLike, resolve_box
from asmc_pin.condition.domain.recorded_motion import read_recording
from asmc_pin.condition.hypotheses import Where
from asmc_pin.condition.search.samples import Domain
from asmc_pin.errors import ParameterError

if TYPE_CHECKING:
    from asmc_pin.arms import Arm


def domains(
    arm: Arm,
    *,
    box: BoxLike,
    payload: PayloadRange,
    armature: ArmatureRange,
    lock: LockChoices,
    along: Any,
    tube_width: float | Sequence[float] | Array | None,
    slices: int,
    period: float | None,
    duration: float | None,
) -> tuple[tuple[Case, ...], Where, list[tuple[Array, Array]]]:
    """One case per joint box and arm; arguments as of `certify`.

    Returns:
        The cases; whether they are of a joint box or of a tube's time slices; and those boxes, each once.

    Raises:
        ParameterError: A malformed range, or a motion without a tube around it.
    """
    found = cases(arm, box, payload, armature, lock)
    if along is None:
        if tube_width is not None:
            raise ParameterError("tube_width", "is around a motion; give the motion with along")
        own = found[0].domain.box
        return tuple(found), "box", [(own.lower, own.upper)]
    if tube_width is None:
        raise ParameterError("along", "a motion is a line, and a proof is about boxes; give the tube around it in rad")
    first = found[0].domain.arm
    if isinstance(along, str | Path):
        along = read_recording(along, first)
    motion = motion_of(along, first.nv, period=period, duration=duration)
    check_units(first, along, motion)
    slice_boxes = tube(motion, tube_width, slices, first.joint_kinds)
    # Where the motion rests, one slice's box is another's: that is one statement, and proven once.
    known = {(part.lower.tobytes(), part.upper.tobytes()): part for part in reversed(slice_boxes)}
    parts = [part for part in slice_boxes if known[part.lower.tobytes(), part.upper.tobytes()] is part]
    sliced = []
    for case in found:
        domain = case.domain
        for part in parts:
            around = resolve_box(domain.arm, (part.lower, part.upper))
            label = f"{part.start:g} to {part.end:g} s"
            sliced.append(
                Case(
                    Domain(domain.arm, around, domain.armature_lower, domain.armature_upper),
                    ", ".join(filter(None, (case.label, label))),
                )
            )
    return tuple(sliced), "tube", [(part.lower, part.upper) for part in parts]
