"""`explore`: a page on which joints and M̄ are moved, written or served."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from asmc_pin.condition import verify
from asmc_pin.condition.domain.joint_box import Box, BoxLike, resolve_box
from asmc_pin.condition.norm.two_conditions import Condition
from asmc_pin.condition.search.worst_case import SAMPLES
from asmc_pin.disk.file_access import check_writable
from asmc_pin.disk.files import write_whole
from asmc_pin.errors import ParameterError
from asmc_pin.exploring.explored_arm import Gains, KnownBoxes, described
from asmc_pin.exploring.explorer_page import explorer_page
from asmc_pin.exploring.known_boxes import boxes_of_certificate, boxes_within
from asmc_pin.words.units import check_period

if TYPE_CHECKING:
    from asmc_pin.arms import Arm
    from asmc_pin.condition import ConditionReport


def explore(
    arm: Arm,
    mbar: Any,
    *,
    condition: Condition = "lemma1",
    box: BoxLike = None,
    ks: float = 10.0,
    beta: float = 10.0,
    period: float = 0.001,
    budget: float | None = None,
    certificate: str | Path | None = None,
    samples: int = SAMPLES,
    seed: int = 0,
    html: str | Path | None = None,
    port: int = 0,
    open_browser: bool = False,
) -> Path | None:
    """Make a page on which the joints, M̄ and the gains are moved, and all figures follow at once.

    The page computes M(q) itself, and shows the norm, the worst direction, eigenvalues, the gains for which the frozen
    sampled loop is stable, and a map over two joints. What it says of a configuration is evaluated there; only boxes
    with a proof say more. Served, it also says whether links collide.

    Args:
        arm: The arm.
        mbar: Diagonal of M̄, one value or nv of them, kg·m².
        condition: ``lemma1`` or ``weighted``.
        box: {joint: (lo, hi)} in rad (m where prismatic); the other joints keep the arm's own range.
        ks: k_s of the loop at first, 1/s.
        beta: β, 1/s.
        period: L, s.
        budget: Prove and refute joint boxes for so long, s, and show those that meet the map; None for none.
        certificate: A certificate of this M̄ on this arm, whose boxes are shown; it is checked first.
        samples: Of the search for the worst configuration.
        seed: Of the same.
        html: Write a page that opens offline to this file, and serve nothing.
        port: Without a file: of the server on 127.0.0.1, which no other machine reaches; 0 takes a free one.
        open_browser: Without a file: open the page in the user's browser as well.

    Returns:
        The file that was written; None after serving, which lasts until Ctrl-C is pressed.

    Raises:
        ParameterError: A malformed option, both `budget` and `certificate`, boxes of an arm whose joints mimic others,
            a certificate that is not valid or about something else, or a port that is taken.
        ArmError: A prismatic joint has no range.
        ResultError: The certificate cannot be read, or the page cannot be written.
    """
    if html is not None:
        check_writable(html)
    gains = checked_gains(ks, beta, period)
    explored = look(
        arm,
        mbar,
        condition=condition,
        box=box,
        budget=budget,
        certificate=certificate,
        samples=samples,
        seed=seed,
    )
    if html is not None:
        return explored.write(html, gains)
    explored.serve(gains, port, open_browser=open_browser)
    return None


@dataclass(frozen=True, eq=False)
class Explored:
    """What a page is made of.

    Attributes:
        arm: The arm.
        report: What a search of the joint box found for M̄.
        boxes: Boxes to show; None for none.
    """

    arm: Arm
    report: ConditionReport
    boxes: KnownBoxes | None

    @property
    def box(self) -> Box:
        """The joint box."""
        return resolve_box(self.arm, self.report.box)

    def page(self, gains: Gains, *, live: bool) -> str:
        """HTML of the page; a live one asks its server whether links collide."""
        data, notes = described(self.arm, self.report, self.box, gains, self.boxes, live=live)
        return explorer_page(self.report, data, notes)

    def write(self, html: str | Path, gains: Gains) -> Path:
        """Write the page that opens offline."""
        write_whole(html, self.page(gains, live=False))
        return Path(html)

    def serve(self, gains: Gains, port: int, *, open_browser: bool = False) -> None:
        """Serve the page on 127.0.0.1 until Ctrl-C is pressed."""
        from asmc_pin.exploring.live_server import serve_explorer

        serve_explorer(self.arm, self.page(gains, live=True), self.box, port, open_browser=open_browser)


def look(
    arm: Arm,
    mbar: Any,
    *,
    condition: Condition,
    box: BoxLike,
    budget: float | None,
    certificate: str | Path | None,
    samples: int = SAMPLES,
    seed: int = 0,
    progress: Callable[[str, float], None] | None = None,
) -> Explored:
    """Do what takes time: search the worst configuration, prove boxes; arguments as of `explore`.

    `progress` is called with what is being done and the share of it that is done.
    """
    if budget is not None and certificate is not None:
        raise ParameterError("certificate", "has boxes of its own; leave the budget out")
    if progress is not None:
        progress("searching the worst configuration", 0.0)
    report = verify(arm, mbar, condition=condition, box=box, samples=samples, seed=seed)
    boxes = None
    if certificate is not None:
        boxes = boxes_of_certificate(arm, report, Path(certificate), progress)
    elif budget is not None:
        boxes = boxes_within(arm, report, budget, progress)
    return Explored(arm, report, boxes)


def checked_gains(ks: float, beta: float, period: float) -> Gains:
    """The gains that the page begins with.

    Raises:
        ParameterError: One is no positive number, or the period is hardly meant in s.
    """
    for name, value in (("ks", ks), ("beta", beta), ("period", period)):
        if not (isinstance(value, int | float | np.floating) and math.isfinite(value) and value > 0.0):
            raise ParameterError(name, f"{value!r} given, one positive number expected")
    check_period(period)
    return Gains(float(ks), float(beta), float(period))
