"""The arm that a command is about: loaded as its options say, with what a reader has to know on standard error."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Any

from asmc_pin.cli.console import announce_compiling, note
from asmc_pin.cli.option_groups.loading_options import LoadingOptions
from asmc_pin.cli.option_groups.loading_values import load_keywords, single_keywords

if TYPE_CHECKING:
    from asmc_pin.arms import Arm


def open_domain(source: str, loading: LoadingOptions) -> tuple[Arm, dict[str, Any]]:
    """Load an arm as the command line describes it, its warnings on standard error.

    Args:
        source: ARM.
        loading: The options.

    Returns:
        The arm with all that has one value, and the ranges and choices as keywords of `verify` and its fellows.
    """
    from asmc_pin.arms.registry import find

    single, ranges = load_keywords(loading)
    find(source)  # a name that is none is told before anything heavy is loaded
    announce_compiling()
    from asmc_pin.arms import load_arm

    arm = load_arm(source, **single)
    if loading.plant is not None:
        from asmc_pin.experiment.measured_values import check_measured_arm, read_measured

        check_measured_arm(read_measured(Path(loading.plant)), arm.source_name, Path(loading.plant).name)
    for proviso in arm.provisos:
        if not proviso.headline:
            note(f"{proviso.kind}: {proviso.text}")
    warnings = list(arm.warnings)
    if "payload" in ranges:
        from asmc_pin.condition.domain.payload_ranges import carrying

        # What is said of every payload of the range.
        laden = [other for other, _ in carrying(arm, ranges["payload"]) if other.payload and other.payload.mass > 0.0]
        common = set.intersection(*(set(other.warnings) for other in laden)) if laden else set()
        warnings += sorted(common - set(warnings))
    for warning in warnings:
        note(f"warning: {warning}")
    for proviso in arm.provisos:
        if proviso.headline:
            note(f"warning: {proviso.kind}: {proviso.text}")
    tell_doubts(arm, source)
    return arm, ranges


def tell_doubts(arm: Arm, source: str) -> None:
    """Say on standard error what puts an arm's M(q) in doubt, a line each, and where there is more."""
    from asmc_pin.inspection.inspecting import serious_doubts

    doubts = serious_doubts(arm)
    for doubt in doubts:
        note(f"warning: doubtful: {doubt.text}")
    if doubts:
        note(f"warning: see 'asmc-pin inspect {shlex.quote(source)}' for what was read")


def open_single(source: str, loading: LoadingOptions) -> Arm:
    """The same where a range means nothing.

    Raises:
        ParameterError: An option gives a range or a choice.
    """
    single_keywords(loading)
    arm, _ = open_domain(source, loading)
    return arm
