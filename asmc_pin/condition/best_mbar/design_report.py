"""What designing M̄ says."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.condition.condition_report import ConditionReport, stop_lines
from asmc_pin.condition.hypotheses import Condition, Hypotheses
from asmc_pin.words.joint_units import column_cells, column_head
from asmc_pin.words.shown import UNDEFINED, Cells, Shown
from asmc_pin.words.text import printable, rounded_down, rounded_up


@dataclass(frozen=True, eq=False)
class DesignPoint:
    """One M̄, with the norm and the bandwidth that a search finds for it over the whole domain.

    Attributes:
        norm: Largest norm of the condition.
        bandwidth: Smallest λ_min(M⁻¹M̄): the slowest mode of the estimate converges by 1 − this per sample.
        mbar: Shape (nv,), kg·m².
    """

    norm: float
    bandwidth: float
    mbar: Array


@dataclass(frozen=True, eq=False)
class DesignBranch:
    """What the program of one branch on the base came to.

    Attributes:
        joints: The branch.
        norm: Largest norm of its block that a search found.
        bound: No M̄ has a smaller norm of this block, rigorously; 0 where λ_min(M⁻¹M̄) was the objective.
        bandwidth: Smallest λ_min(M⁻¹M̄) of its block that a search found.
    """

    joints: tuple[str, ...]
    norm: float
    bound: float
    bandwidth: float


@dataclass(frozen=True, eq=False)
class DesignLimit:
    """A configuration that keeps M̄ from being better.

    Attributes:
        q: Shape (nv,), rad (m where prismatic).
        share: Of all multipliers of the program; what limits most comes first.
        joint: The joint whose own inertia there would change most.
        side: ``small``: M̄ is too small for the inertia there. ``large``: it is too large.
        case: Which payload end or lock choice; empty without ranges.
    """

    q: Array
    share: float
    joint: str
    side: Literal["small", "large"]
    case: str


PUBLISHED_ROTORS = "the published rotors"


@dataclass(frozen=True, eq=False)
class ArmaturePurchase:
    """How far the least norm would fall if armature were added.

    Attributes:
        where: A joint, ``every joint``, or `PUBLISHED_ROTORS`.
        armature: Added, shape (nv,), kg·m².
        norm: Least norm that could then be designed.
    """

    where: str
    armature: Array
    norm: float


@dataclass(frozen=True, eq=False)
class WeightedDesign:
    """What the weighted condition would allow. It is not Lemma 1.

    Attributes:
        least: The M̄ of least weighted norm.
        scale: Factor by which the M̄ found for Lemma 1 could grow before the weighted condition breaks.
        scale_lemma1: The same before Lemma 1 breaks.
    """

    least: DesignPoint
    scale: float
    scale_lemma1: float


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class DesignReport(Shown):
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

    @property
    def arm(self) -> str:
        """Name of the arm."""
        return self.hypotheses.arm

    @property
    def joints(self) -> tuple[str, ...]:
        """Its moving joints, base first."""
        return self.hypotheses.joints

    @property
    def condition(self) -> Condition:
        """``lemma1`` or ``weighted``."""
        return self.hypotheses.condition

    @property
    def formula(self) -> str:
        """The condition as an inequality."""
        return self.hypotheses.formula

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
            "limits": [
                {"q": item.q.tolist(), "share": item.share, "joint": item.joint, "side": item.side, "case": item.case}
                for item in self.limits
            ],
            "by_armature": None if self.by_armature is None else self.by_armature.tolist(),
            "trade_off": [_point(point) for point in self.trade_off],
            "armature_buys": [
                {"where": item.where, "armature": item.armature.tolist(), "norm": item.norm}
                for item in self.armature_buys
            ],
            "weighted": None,
            "branches": [
                {
                    "joints": list(item.joints),
                    "norm": item.norm,
                    "bound": item.bound or None,
                    "bandwidth": item.bandwidth,
                }
                for item in self.branches
            ],
        }
        if self.weighted is not None:
            scales = {"scale": self.weighted.scale, "scale_lemma1": self.weighted.scale_lemma1}
            content["weighted"] = _point(self.weighted.least) | scales
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
            return [*self._put_together(), *self._limits(), *(_bought(item) for item in self.armature_buys)]
        assert self.check is not None
        lines = [
            *([f"not all was done: {self.unfinished}"] if self.unfinished else []),
            *self._proven(self.check),
            *(["M̄ = " + ",".join(repr(float(value)) for value in self.mbar)] if with_mbar else []),
            *self._put_together(),
            f"slowest mode of the estimate: λ_min(M⁻¹M̄) = {self.bandwidth:.4g} per sample",
            *self._limits(),
        ]
        if len(self.trade_off) > 1:
            curve = ", ".join(f"{point.norm:.5g} / {point.bandwidth:.4g}" for point in self.trade_off)
            lines.append(f"trade-off, norm / λ_min(M⁻¹M̄), from least norm to largest bandwidth: {curve}")
        lines += [_bought(item) for item in self.armature_buys]
        if self.weighted is not None:
            other = self.weighted
            lines.append(
                "the weighted condition, which is weaker and not Lemma 1, would allow a weighted norm of "
                f"{other.least.norm:.5g} with another M̄; this M̄ times {other.scale:.4g} breaks it, times "
                f"{other.scale_lemma1:.4g} breaks Lemma 1"
            )
        return lines

    def _put_together(self) -> list[str]:
        if not self.branches:
            return []
        norms = ", ".join(
            f"{item.norm:.6g} (joints {', '.join(printable(name) for name in item.joints)})" for item in self.branches
        )
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

    def _limits(self) -> list[str]:
        return [
            f"limited at q = {_list(item.q)} ({item.share:.0%}{', ' + item.case if item.case else ''}): M̄ is too "
            f"{item.side} for the inertia that joint '{printable(item.joint)}' has there"
            for item in self.limits
        ]


def _point(point: DesignPoint) -> dict[str, Any]:
    return {"norm": point.norm, "bandwidth": point.bandwidth, "mbar": point.mbar.tolist()}


def _bought(item: ArmaturePurchase) -> str:
    if item.where == PUBLISHED_ROTORS:
        return (
            f"with the published rotors, {_list(item.armature)} kg·m², a norm of {item.norm:.5g} would be possible: "
            "load the arm with armature 'published'"
        )
    return (
        f"armature of {_list(item.armature)} kg·m² more on {printable(item.where)} would allow a norm of "
        f"{item.norm:.5g}"
    )


def _list(values: Array) -> str:
    return "(" + ", ".join(f"{value:.4g}" for value in np.where(np.abs(values) < 5e-5, 0.0, values)) + ")"
