"""The best M̄: least norm, or fastest estimate, over boxes, payloads and armatures."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, get_args

import numpy as np

from asmc_pin.clock import Clock
from asmc_pin.condition.best_mbar.by_branch import Designed, blocks_of, exchange_all
from asmc_pin.condition.best_mbar.convex_program import Bounds, Form
from asmc_pin.condition.best_mbar.design_findings import ArmaturePurchase, DesignBranch, DesignPoint
from asmc_pin.condition.best_mbar.design_report import DesignReport
from asmc_pin.condition.best_mbar.exchange import ROUNDS, DesignProgress, Pace
from asmc_pin.condition.best_mbar.limits_of_mbar import (
    limits_of,
    other_condition,
    what_armature_buys,
    what_published_rotors_buy,
)
from asmc_pin.condition.best_mbar.mbar_bounds import BoundsLike, read_bounds
from asmc_pin.condition.domain.arm_ranges import ArmatureRange, Case, LockChoices, PayloadRange, cases
from asmc_pin.condition.domain.joint_box import BoxLike
from asmc_pin.condition.norm.two_conditions import Condition, check_condition
from asmc_pin.condition.premises import hypotheses_of
from asmc_pin.condition.verifying import verify
from asmc_pin.errors import ParameterError
from asmc_pin.words.choices import Objective as Objective

if TYPE_CHECKING:
    from asmc_pin.arms import Arm


MARGIN = 0.1
"""Share of the least norm's distance from 1 that `bandwidth` keeps unless told a level."""

_TRADE_OFF = (0.5, 0.25)


def design(
    arm: Arm,
    *,
    condition: Condition = "lemma1",
    objective: Objective = "contraction",
    form: Form = "diagonal",
    bounds: BoundsLike = None,
    level: float | None = None,
    box: BoxLike = None,
    payload: PayloadRange = None,
    armature: ArmatureRange = None,
    lock: LockChoices = None,
    explain: bool = True,
    seed: int = 0,
    budget: float = np.inf,
    progress: Callable[[DesignProgress], None] | None = None,
) -> DesignReport:
    """Find M̄ by a convex program with an exchange of worst configurations.

    Branches on the base are blocks of M(q): with one m̄ per joint each has a program of its own, and M̄ is put together.
    A program has a few configurations only. So it bounds from below what any M̄ can reach, rigorously (`dual_bound`).
    The search over the whole box gives the norm of the program's M̄. The two meet to a thousandth of 1 − γ, or the
    report shows how far apart they stayed.

    Args:
        arm: The arm.
        condition: ``lemma1`` or ``weighted``.
        objective: ``contraction``: least norm. ``bandwidth``: largest guaranteed λ_min(M⁻¹M̄) with a norm of at most
            `level`; the M̄ of least norm can leave a joint with a slow estimate.
        form: ``diagonal``: one value per joint. ``scalar``: M̄ = m·I.
        bounds: See `BoundsLike`.
        level: Largest norm that ``bandwidth`` allows, below 1; default 1 − 0.1 (1 − the least norm).
        box: Joint box, as for `verify`.
        payload: As for `verify`.
        armature: As for `verify`.
        lock: As for `verify`.
        explain: Also find the other objective and their trade-off, what armature would buy, and what the weighted
            condition would allow.
        seed: Of the searches.
        budget: Wall time after which to stop with what there is, s; the first M̄ is found and checked in any case, and
            compiling, once after installation, is not counted.
        progress: Called every round.

    Returns:
        The report; its verdict is ``infeasible`` where no M̄ within the bounds satisfies the condition.

    Raises:
        ParameterError: Malformed options.
        ArmError: A prismatic joint has no range.
    """
    clock = Clock()
    condition = check_condition(condition)
    for name, value, known in (("objective", objective, get_args(Objective)), ("form", form, get_args(Form))):
        if value not in known:
            raise ParameterError(name, f"'{value}' given, one of {', '.join(known)} expected")
    if level is not None and not (isinstance(level, int | float | np.number) and 0.0 < level < 1.0):
        raise ParameterError("level", f"{level!r} given, a norm between 0 and 1 expected")
    all_cases = cases(arm, box, payload, armature, lock)
    limits = read_bounds(all_cases[0].domain.arm, bounds, form)
    if not (isinstance(budget, int | float | np.number) and budget > 0.0):
        raise ParameterError("budget", f"{budget!r} given, a positive number of seconds expected")
    pace = Pace(budget, progress, clock, "least norm")
    blocks = blocks_of([case.domain for case in all_cases], limits, seed)
    least = exchange_all(blocks, condition, limits, pace=pace)
    assert least is not None
    missing = _not_met(least, f"a better M̄ than that of {least.rounds} programs", pace)
    rotors: tuple[ArmaturePurchase, ...] = ()
    if explain and pace.left() > 0.0:
        # First of all that explains: where they are known they help most, and the program with them is quick.
        pace.doing = "what the published rotors buy"
        rotors = what_published_rotors_buy(all_cases, condition, limits, seed, pace)
    if least.bound >= 1.0:
        return _infeasible(all_cases, condition, objective, form, limits, least, clock.seconds(), rotors)
    ceiling = 1.0 - MARGIN * (1.0 - least.norm) if level is None else level
    fastest = None
    wanted = objective == "bandwidth" or (explain and least.norm < 1.0)
    if wanted and ceiling < 1.0 and (objective == "bandwidth" or pace.left() > 0.0):
        pace.doing = "largest bandwidth"
        fastest = exchange_all(blocks, condition, limits, ceiling, pace)
    chosen = least if objective == "contraction" else fastest
    if chosen is None and least.norm <= ceiling:
        chosen = least
        missing.append("the largest bandwidth (the solver found no optimum)")
    elif chosen is not None and chosen is not least:
        missing += _not_met(chosen, f"a larger bandwidth than that of {chosen.rounds} programs", pace)
    if chosen is None:
        return _infeasible(all_cases, condition, objective, form, limits, least, clock.seconds(), rotors)
    mbar = chosen.mbar
    ranges: dict[str, Any] = {"box": box, "payload": payload, "armature": armature, "lock": lock}
    # Where time is up, the search that checks is as light as those of a round, and says so itself.
    samples, starts = (2**16, 128) if pace.left() > 0.0 else (2**12, 16)
    check = verify(arm, mbar, condition=condition, seed=seed + 1000, samples=samples, starts=starts, **ranges)
    curve = [point_of(least)]
    extra: dict[str, Any] = {"armature_buys": rotors}
    if explain and least.norm < 1.0:
        for share in _TRADE_OFF:
            between = 1.0 - share * (1.0 - least.norm)
            if between < ceiling and pace.left() > 0.0:
                pace.doing = "trade-off between the two"
                if found := exchange_all(blocks, condition, limits, between, pace):
                    curve.append(point_of(found))
        if pace.left() > 0.0:
            pace.doing = "what armature buys"
            extra["armature_buys"] += what_armature_buys(all_cases, condition, limits, least, seed, pace)
        if condition == "lemma1" and pace.left() > 0.0:
            pace.doing = "the weighted condition"
            extra["weighted"] = other_condition(all_cases, limits, mbar, seed, pace)
        if pace.left() <= 0.0:
            missing.append(f"all that explains it ({_time_up(pace)})")
    if fastest is not None:
        curve.append(point_of(fastest))
    return DesignReport(
        hypotheses=check.hypotheses,
        objective=objective,
        form=form,
        bounds=(limits.lower, limits.upper),
        verdict=check.verdict,
        mbar=mbar,
        check=check,
        bound=least.bound,
        bandwidth=chosen.bandwidth,
        level=ceiling if objective == "bandwidth" else None,
        rounds=chosen.rounds,
        seconds=clock.seconds(),
        limits=limits_of(all_cases, condition, chosen),
        by_armature=least.by_armature,
        trade_off=tuple(curve),
        branches=branches_of(all_cases, chosen),
        unfinished=f"not looked for, or not to the end: {', '.join(missing)}" if missing else "",
        **extra,
    )


def _not_met(outcome: Designed, what: str, pace: Pace) -> list[str]:
    """What was not found, and why; nothing where search and program met."""
    why = {
        "met": "",
        "time": _time_up(pace),
        "rounds": f"search and program did not meet in {ROUNDS} programs",
        "solver": "the solver found no optimum",
    }[outcome.stopped]
    return [f"{what} ({why})"] if why else []


def _time_up(pace: Pace) -> str:
    return f"the budget of {pace.budget:g} s was up"


def point_of(outcome: Designed) -> DesignPoint:
    """What an outcome is worth."""
    return DesignPoint(outcome.norm, outcome.bandwidth, outcome.mbar)


def branches_of(all_cases: list[Case], outcome: Designed) -> tuple[DesignBranch, ...]:
    """What each branch's own program came to; nothing where there was one program for all."""
    if len(outcome.parts) == 1:
        return ()
    names = all_cases[0].domain.arm.joint_names
    return tuple(
        DesignBranch(tuple(names[i] for i in joints), part.norm, part.solution.bound, part.bandwidth)
        for part, joints in zip(outcome.parts, outcome.joints, strict=True)
    )


def _infeasible(
    all_cases: list[Case],
    condition: Condition,
    objective: Objective,
    form: Form,
    limits: Bounds,
    least: Designed,
    seconds: float,
    rotors: tuple[ArmaturePurchase, ...],
) -> DesignReport:
    return DesignReport(
        hypotheses=hypotheses_of(all_cases, None, condition),
        objective=objective,
        form=form,
        bounds=(limits.lower, limits.upper),
        verdict="infeasible",
        mbar=None,
        check=None,
        bound=least.bound,
        bandwidth=None,
        level=None,
        rounds=least.rounds,
        seconds=seconds,
        branches=branches_of(all_cases, least),
        limits=limits_of(all_cases, condition, least),
        by_armature=least.by_armature,
        armature_buys=rotors,
    )
