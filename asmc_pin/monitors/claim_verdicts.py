"""Each claim on one trial, judged from the monitors' arrays."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from asmc_pin._typing import Array, BoolArray, IntArray
from asmc_pin.controllers import Baek2016
from asmc_pin.monitors.claim_texts import CAUSES, Claim, judge, percent, weigh
from asmc_pin.monitors.law_signals import DRIVE, NOISE, SATURATION
from asmc_pin.monitors.lyapunov_monitor import SAMPLING, Lyapunov
from asmc_pin.monitors.tde_monitor import FRICTION, SWITCHING, Contraction
from asmc_pin.words.remedy_texts import MBAR_REMEDY

# Growth of N below this part of its largest value is round-off.
_ROUND_OFF = 1e-9
_SHORT = "the run is too short"


def lemma1(trial: int, time: Array, found: Contraction) -> Claim:
    """Lemma 1's condition at every tick."""
    norm = found.norm
    alive = np.isfinite(norm)
    if not alive.any():
        return Claim("lemma1", trial, "not tested", reason=_SHORT)
    seen = f"between {np.nanmin(norm):.4f} and {np.nanmax(norm):.4f}, at the ticks"
    text = f"neither sampling nor the drive: M̄ does not suit M(q) there; {MBAR_REMEDY}"
    # At exactly 1 the condition is broken too.
    excess = np.where(norm >= 1.0, np.maximum(norm - 1.0, np.finfo(float).tiny), -1.0)
    return judge("lemma1", trial, time, excess, alive, None, seen, _SHORT, f"{seen}; {text}")


def contraction(trial: int, time: Array, found: Contraction) -> Claim:
    """Whether ‖N‖₂ grew from tick to tick, and what brought in the growth."""
    checked = np.isfinite(found.growth)
    if not checked.any():
        return Claim("contraction", trial, "not tested", reason=_SHORT)
    slack = _ROUND_OFF * np.max(found.size, initial=0.0, where=np.isfinite(found.size))
    excess = np.where(checked, found.growth, 0.0) - slack
    over = checked & (excess > 0.0)
    # A cause is what, had it not changed in the period, would have left no growth; the rest is sampling.
    causes = _first_without([SATURATION, NOISE, DRIVE], found, slack, CAUSES, CAUSES.index(SAMPLING))
    # Where what was there grows by itself, the hypothesis is broken, and none of these is to blame.
    itself = np.nan_to_num(found.carried) >= 1.0
    causes = np.where(itself, -1, causes)
    sampled = over & (causes == CAUSES.index(SAMPLING))
    names = [SWITCHING, FRICTION, "load and reference"]
    kinds = _first_without(names[:2], found, slack, names, 2)
    counts = {name: int(np.sum(sampled & (kinds == i))) for i, name in enumerate(names)}
    listed = ", ".join(f"{name} in {count}" for name, count in counts.items() if count)
    shrinks = np.isfinite(found.carried)
    seen = ""
    if shrinks.any():
        seen = f"the old error alone shrinks to {np.median(found.carried[shrinks]):.3g} of itself in a period (median)"
    grown = int(np.sum(over & itself))
    alone = f"the old error grows by itself in {grown} ticks, as Lemma 1's condition is broken there" if grown else ""
    text = "; ".join(part for part in (alone, f"what changed in a period: {listed}" if listed else "", seen) if part)
    return judge("contraction", trial, time, excess, checked, causes, seen, _SHORT, text)


def _first_without(
    tried: list[str], found: Contraction, slack: float, names: tuple[str, ...] | list[str], otherwise: int
) -> IntArray:
    """Index in `names` of what leaves least growth at each tick, if that is none; else `otherwise`."""
    known = [name for name in tried if name in found.without]
    result = np.full(len(found.growth), otherwise)
    if known:
        left = np.nan_to_num(np.stack([found.without[name] for name in known]), nan=np.inf)
        best = np.argmin(left, axis=0)
        index = np.array([names.index(name) for name in known])
        result = np.where(left.min(axis=0) <= slack, index[best], otherwise)
    return result


def about_baek2016(trial: int, time: Array, gain: Array, found: Lyapunov, law: Baek2016) -> list[Claim]:
    """Lemma 2, (16), t_ε and (21); `gain` is k̂ of this trial, shape (T, nv), rad/s²."""
    starts = _excursions(found.outside)
    return [
        _lemma2(trial, time, gain, found, starts),
        _decrease(trial, time, found, law),
        _entry(trial, time, found, law),
        _bounded(trial, time, found, law, starts),
    ]


def _lemma2(trial: int, time: Array, gain: Array, found: Lyapunov, starts: IntArray) -> Claim:
    known = np.isfinite(found.value)
    peak, allowed = (np.fmax.reduce(x[known], axis=0, initial=0.0) for x in (gain, found.gain_bound))
    joint = int(np.argmax(peak / allowed))
    over = np.where(known[:, None], gain - found.gain_bound * (1.0 + 1e-12), -np.inf).max(axis=1)
    seen = f"nearest: joint {joint + 1}, at most {peak[joint]:.4g}, bound {allowed[joint]:.4g} rad/s²"
    return judge("lemma2", trial, time, over, known, _blame(found.parts, starts, over > 0.0), seen, _SHORT, seen)


def _decrease(trial: int, time: Array, found: Lyapunov, law: Baek2016) -> Claim:
    checked = found.claimed & np.isfinite(found.excess)
    over = np.where(checked, found.excess - found.round_off, -np.inf)
    broken = over > 0.0
    causes = np.argmax(np.stack([np.nan_to_num(found.parts[name]) for name in CAUSES]), axis=0)
    seen = text = ""
    if checked.any() and not broken.any():
        seen = f"V̇ + β‖s‖² was at most {np.max(found.excess[checked]):.3g} rad²/s³ in {int(checked.sum())} periods"
    if broken.any():
        share = percent(float(np.mean(found.crossing[broken])))
        worst = int(np.argmax(over))
        text = (
            f"in {share} of these ticks s of a joint changes its sign within the period; "
            f"at worst {found.excess[worst] / found.decay[worst]:.3g} times β‖s‖²"
        )
    never = f"‖s‖_∞ never reached ε = {law.epsilon:g}"
    return judge("eq16", trial, time, over, checked, causes, seen, never, text)


def _entry(trial: int, time: Array, found: Lyapunov, law: Baek2016) -> Claim:
    known = np.isfinite(found.value)
    if not known.any():
        return Claim("t_eps", trial, "not tested", reason=_SHORT)
    latest = time[0] + found.value[0] / (law.beta * law.epsilon**2)
    entered = known & ~found.outside
    end = float(time[known][-1])
    said = f"V(0)/(βε²) allows {latest:.3g} s"
    entry = float(time[np.argmax(entered)]) if entered.any() else np.inf
    if entry <= latest:
        return Claim("t_eps", trial, "held", checked=1, reason=f"t_ε = {entry:.4g} s; {said}")
    if end < latest:
        return Claim("t_eps", trial, "not tested", reason=f"s did not enter ‖s‖_∞ < ε by {end:.4g} s, but {said}")
    cause = CAUSES[weigh(found.parts, slice(0, int(np.sum(known))))]
    tail = f"t_ε = {entry:.4g} s" if np.isfinite(entry) else f"s did not enter by {end:.4g} s"
    last = min(entry, end)
    return Claim(
        "t_eps",
        trial,
        "broken",
        checked=1,
        broken=1,
        first_time=float(latest),
        worst_time=last,
        amount=float(last - latest),
        causes={cause: 1},
        reason=f"{cause}; {tail}, {said}",
    )


def _bounded(trial: int, time: Array, found: Lyapunov, law: Baek2016, starts: IntArray) -> Claim:
    known = np.isfinite(found.value)
    never = f"s never entered ‖s‖_∞ < ε = {law.epsilon:g}, so there is no t_ε"
    checked = known & (np.cumsum(known & ~found.outside) > 0)
    over = np.where(checked, found.s_size - found.s_bound, -np.inf)
    seen = ""
    if checked.any():
        largest = np.max(found.s_size[checked])
        seen = f"largest ‖s‖₂ {largest:.4g}, bound {found.s_bound:.4g} rad/s (Γ* is that of this run)"
    # What carries s over ε is in the step that begins inside: it belongs to the excursion.
    causes = _blame(found.parts, np.maximum(starts - 1, 0), over > 0.0)
    return judge("eq21", trial, time, over, checked, causes, seen, never, seen)


def _excursions(outside: BoolArray) -> IntArray:
    """At each tick the one at which the present stay outside ε began, or the last one did; 0 before the first."""
    begins = outside & ~np.concatenate([[False], outside[:-1]])
    starts: IntArray = np.maximum.accumulate(np.where(begins, np.arange(len(outside)), 0))
    return starts


def _blame(parts: Mapping[str, Array], starts: IntArray, broken: BoolArray) -> IntArray:
    """For each broken tick the cause that added most to V since the excursion began."""
    causes = np.zeros(len(starts), dtype=np.int64)
    for k in np.flatnonzero(broken):
        causes[k] = weigh(parts, slice(int(starts[k]), int(k) + 1))
    return causes
