"""What designing M̄ says."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.condition.best_mbar.design_findings import (
    ArmaturePurchase,
    DesignBranch,
    DesignLimit,
    DesignPoint,
    WeightedDesign,
)
from asmc_pin.condition.condition_report import ConditionReport, stop_lines
from asmc_pin.condition.hypotheses import Hypotheses
from asmc_pin.condition.judged import AboutMbar
from asmc_pin.words.joint_units import column_cells, column_head
from asmc_pin.words.shown import UNDEFINED, Cells
from asmc_pin.words.text import printable, rounded_down, rounded_up


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class DesignReport(AboutMbar):
    """The M̄ that was found, how good it is, and what limits it.

    Attributes:
        hypotheses: What the verdict is about: arm, condition, armature, payload, locked joints, box, and the M̄ if there
            is one.
        objective: ``contraction`` or ``bandwidth``.
        form: ``diagonal`` or ``scalar``.
        bounds: Least and largest m̄ᵢ, each (nv,), kg·m².
        verdict: That of `check`, or ``infeasible``: no M̄ within the bounds satisfies the condition.
        mbar: Shape (nv,), kg·m², not rounded; digits matter. None where infeasible.
        check: M̄ verified by a search with other samples.
        bound: No M̄ within the bounds has a smaller norm: a dual bound, rigorous whatever the solver did, on the
            configurations that the program knew.
        bandwidth: Smallest λ_min(M⁻¹M̄) that a search found.
        level: With ``bandwidth``: the norm that was allowed.
        rounds: Programs solved.
        seconds: Wall time.
        limits: Configurations that limit it, the strongest first.
        by_armature: Derivative of the least norm by the armature of each joint, shape (nv,), 1/(kg·m²).
        trade_off: From the least norm to the largest bandwidth.
        armature_buys: What added armature would buy.
        weighted: What the weighted condition would allow; None for a design under it.
        branches: Where M(q) is block diagonal, and M̄ put together of one program per branch: what each came to.
        unfinished: What was not done because the time was up, in words; empty where all was.
    """

    hypotheses: Hypotheses
    objective: str
    form: str
    bounds: tuple[Array, Array]
    verdict: str
    mbar: Array | None
    check: ConditionReport | None
    bound: float | None
    bandwidth: float | None
    level: float | None
    rounds: int
    seconds: float
    limits: tuple[DesignLimit, ...] = ()
    by_armature: Array | None = None
    trade_off: tuple[DesignPoint, ...] = ()
    armature_buys: tuple[ArmaturePurchase, ...] = ()
    weighted: WeightedDesign | None = None
    branches: tuple[DesignBranch, ...] = ()
    unfinished: str = ""

    def rows(self) -> list[tuple[str, str]]:
        """The hypotheses, and within which bounds M̄ was looked for."""
        return [*self.hypotheses.rows(), ("M̄ looked for", self._within())]

    def to_json_dict(self) -> dict[str, Any]:
        """The object that ``asmc-pin design --json`` prints: that of `verify` for the M̄ found, and more.

        Where infeasible, figures of the M̄ that does not exist are None.
        """
        content: dict[str, Any] = {
            **self.hypotheses.to_json_dict(),
            "verdict": self.verdict,
            "kind": "sampled",
            "lower": None,
            "upper": None,
            "worst_q": None,
            "worst_payload": None,
            "worst_armature": None,
            "configurations": 0,
            "seconds": self.seconds,
        }
        if self.check is not None:
            content |= self.check.to_json_dict() | {"seconds": self.seconds}
        content |= {
            "objective": self.objective,
            "form": self.form,
            "bounds": {
                name: [low, high if np.isfinite(high) else None]
                for name, low, high in zip(self.joints, *(end.tolist() for end in self.bounds), strict=True)
            },
            "bound": self.bound,
            "bound_kind": None if self.bound is None else "rigorous dual bound",
            "bandwidth": self.bandwidth,
            "level": self.level,
            "rounds": self.rounds,
            "unfinished": self.unfinished or None,
            "limits": [item.to_json_dict() for item in self.limits],
            "by_armature": None if self.by_armature is None else self.by_armature.tolist(),
            "trade_off": [point.to_json_dict() for point in self.trade_off],
            "armature_buys": [item.to_json_dict() for item in self.armature_buys],
            "weighted": None if self.weighted is None else self.weighted.to_json_dict(),
            "branches": [item.to_json_dict() for item in self.branches],
        }
        return content

    def lines(self, *, with_mbar: bool = True) -> list[str]:
        """The report in plain words, a line per finding: the verdict, what it is about, and why it is no better.

        Args:
            with_mbar: Whether M̄ is among it; not where gains go with another multiple of it.
        """
        about = [f"{term}: {text}" for term, text in self.rows() if with_mbar or term != "M̄"]
        return [self.headline(), *about, *self.reasons(with_mbar=with_mbar)]

    def table(self) -> Cells:
        """M̄, its bounds and the worst configuration, joint by joint; a dash where there is none."""
        none, slides = [UNDEFINED] * len(self.joints), self.hypotheses.slides
        mbar = none
        if self.mbar is not None:
            mbar = column_cells([f"{value:.6g}" for value in self.mbar], "inertia", slides)
        worst = none
        if self.check is not None:
            worst = column_cells([f"{value:+.6f}" for value in self.check.worst_q], "place", slides)
        ends = (column_cells([f"{value:g}" for value in end], "inertia", slides) for end in self.bounds)
        rows = zip(map(printable, self.joints), mbar, *ends, worst, strict=True)
        heads = [column_head("m̄", "inertia", slides), "at least", "at most", column_head("worst q", "place", slides)]
        return ["joint", *heads], [list(row) for row in rows]

    def headline(self) -> str:
        """The verdict, and what M̄ is worth."""
        title = self.hypotheses.title
        if self.mbar is None:
            bound = "" if self.bound is None else f"; no norm is below {rounded_down(self.bound)} (rigorous dual bound)"
            return f"{title}: no M̄ within the bounds satisfies {self.formula}{bound}"
        assert self.check is not None
        return (
            f"{title}: {self.formula}, largest norm found {self.check.lower:.6g} "
            f"({self.check.verdict}, {self.check.kind}), no M̄ has less than "
            f"{rounded_down(self.bound or 0.0)} (rigorous dual bound)"
        )

    def _within(self) -> str:
        lower, upper = self.bounds
        ends = (
            f"{printable(name)} {low:g}:{'' if np.isinf(high) else f'{high:g}'}"
            for name, low, high in zip(self.joints, lower, upper, strict=True)
            if low > 0.0 or np.isfinite(high)
        )
        kind = "one m̄ for all joints" if self.form == "scalar" else "one m̄ per joint"
        return f"{kind}, within {', '.join(ends) or 'no bounds'}"

    def reasons(self, *, with_mbar: bool = True) -> list[str]:
        """What is proven, what limits M̄, and what would help; a line per finding, M̄ itself among them if asked."""
        if self.mbar is None:
            return [
                *self._put_together(),
                *(item.words() for item in self.limits),
                *(item.words() for item in self.armature_buys),
            ]
        assert self.check is not None
        lines = [
            *([f"not all was done: {self.unfinished}"] if self.unfinished else []),
            *self._proven(self.check),
            *(["M̄ = " + ",".join(repr(float(value)) for value in self.mbar)] if with_mbar else []),
            *self._put_together(),
            f"slowest mode of the estimate: λ_min(M⁻¹M̄) = {self.bandwidth:.4g} per sample",
            *(item.words() for item in self.limits),
        ]
        if len(self.trade_off) > 1:
            curve = ", ".join(f"{point.norm:.5g} / {point.bandwidth:.4g}" for point in self.trade_off)
            lines.append(f"trade-off, norm / λ_min(M⁻¹M̄), from least norm to largest bandwidth: {curve}")
        lines += [item.words() for item in self.armature_buys]
        return lines if self.weighted is None else [*lines, self.weighted.words()]

    def _put_together(self) -> list[str]:
        if not self.branches:
            return []
        norms = ", ".join(item.words() for item in self.branches)
        return [
            f"M(q) is block diagonal, a block for each of {len(self.branches)} branches on the base: M̄ is put together "
            f"of a program for each, and the norm is the largest of theirs: {norms}"
        ]

    @staticmethod
    def _proven(check: ConditionReport) -> list[str]:
        if check.kind != "certified":
            return []
        if not check.scale_proven:
            return ["nothing is proven of it over the box", *stop_lines(check.reason)]
        bound = "" if check.upper is None else f"the norm is at most {rounded_up(check.upper)} over the box, and "
        proven = f"proven: {bound}the condition holds for M̄ times {rounded_down(check.scale_proven)}"
        return [proven, *stop_lines(check.reason)]
