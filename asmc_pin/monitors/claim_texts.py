"""What the paper claims, held against a run: held, or broken, when, by how much and why."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal, Self, get_args

import numpy as np

from asmc_pin._typing import Array, BoolArray, IntArray
from asmc_pin.monitors.law_signals import DRIVE, NOISE, SATURATION
from asmc_pin.monitors.lyapunov_monitor import SAMPLING

Status = Literal["held", "broken", "not tested", "not tested after", "not applicable"]
STATUSES: tuple[Status, ...] = get_args(Status)

CAUSES = (SAMPLING, SATURATION, NOISE, DRIVE)
"""What can break a claim: finite L; torque limits; what the sensors report; what else the drive does to the torque."""


@dataclass(frozen=True)
class ClaimText:
    """A claim in general.

    Attributes:
        title: Its name in tables.
        text: What it says.
        unit: Of the amount by which it is broken.
        latex: Its heading in a LaTeX table.
        ticks: Which ticks it is checked at, as it follows a number of them.
        adaptive: Whether it speaks of the adaptive law (11) alone.
        sources: The laws whose sources claim it, in words; empty for what Baek (2016) proves. What it says of each,
            with its figures, is the law's own: see `asmc_pin.controllers.TdeLaw.promises`.
    """

    title: str
    text: str
    unit: str
    latex: str
    ticks: str
    adaptive: bool = False
    sources: str = ""

    @property
    def asked_of(self) -> str:
        """Of which laws it is asked."""
        return self.sources or ("the adaptive law" if self.adaptive else "every law with an M̄")


STATEMENTS: Mapping[str, ClaimText] = {
    "lemma1": ClaimText(
        "Lemma 1 (condition)", "‖I − M(q)⁻¹M̄‖₂ < 1 along the motion", "1", r"$\|I - M^{-1}\bar{M}\|_2 < 1$", "ticks"
    ),
    "contraction": ClaimText(
        "Lemma 1 (contraction)",
        "‖N‖₂ does not grow from tick to tick (as L → 0 nothing comes in)",
        "rad/s²",
        r"$\|N\|_2$ falls",
        "ticks after the first",
    ),
    "lemma2": ClaimText(
        "Lemma 2", "k̂ᵢ < k̂ᵢ*, with the bound that (12) and (16) give", "rad/s²", "Lemma 2", "ticks", True
    ),
    "eq16": ClaimText(
        "(16)", "V̇ ≤ −β‖s‖² while ‖s‖_∞ ≥ ε", "rad²/s³", "(16)", "periods with ‖s‖_∞ ≥ ε at both ends", True
    ),
    "t_eps": ClaimText(
        "finite t_ε", "s enters ‖s‖_∞ < ε, by V/(βε²) after the start", "s", r"$t_\varepsilon$", "run", True
    ),
    "eq21": ClaimText("Theorem 1 (21)", "‖s‖₂ < √(nε² + k̃_M) from t_ε on", "rad/s", "(21)", "ticks from t_ε on", True),
    "width": ClaimText(
        "|s| < ε",
        "once |sᵢ| < ε, it stays so",
        "rad/s",
        r"$|s| < \varepsilon$",
        "ticks from then on",
        sources="barrier",
    ),
    "finite_time": ClaimText(
        "finite time",
        "once |σᵢ| ≤ Φ it stays so, and |eᵢ| ≤ Φ by |e₀|^{1−1/p}/(B^{1/p}(1 − 1/p)) later",
        "rad",
        "finite time",
        "ticks from then on",
        sources="ntsm",
    ),
    "second_order": ClaimText(
        "second-order sliding",
        "once reached, |s| ≤ c₁L² and |ds/dt| ≤ c₂L, while the push on s changes slowly enough",
        "times its bound",
        "second order",
        "ticks in which it is reached",
        sources="sta",
    ),
    "gain": ClaimText(
        "bounded gain",
        "k̂ keeps to the bound of its source's proof",
        "rad/s²",
        "gain bounded",
        "ticks",
        sources="plestan2010 and barrier",
    ),
}
"""The claims by their keys, in the order of the tables."""

BAEK: Mapping[str, ClaimText] = {key: item for key, item in STATEMENTS.items() if not item.sources}
"""Those of them that Baek (2016) proves."""


@dataclass(frozen=True)
class Claim:
    """One claim on one trial.

    Attributes:
        key: Key of `STATEMENTS`.
        trial: Index of the trial.
        status: ``"not tested"`` where the run gives no occasion to break it; ``"not tested after"`` where it was not
            broken up to the time `until` at which the trial diverged.
        checked: Ticks at which it was checked.
        broken: Ticks at which it was broken.
        first_time: When it was first broken, s; NaN if it was not.
        worst_time: When it was broken by most, s.
        amount: By how much there, in the statement's unit.
        causes: Number of broken ticks by cause; where they do not add up to `broken`, the claim itself is at fault.
        reason: Why, in plain words; what was seen where it held.
        until: When the trial diverged, s: nothing is known after that. NaN where it ran to its end.
    """

    key: str
    trial: int
    status: Status
    checked: int = 0
    broken: int = 0
    first_time: float = np.nan
    worst_time: float = np.nan
    amount: float = np.nan
    causes: Mapping[str, int] = field(default_factory=dict)
    reason: str = ""
    until: float = np.nan

    @property
    def statement(self) -> ClaimText:
        """What it says in general."""
        return STATEMENTS[self.key]

    def cut_short(self, until: float) -> Self:
        """The same claim on a trial that diverged at a time, s: what had held so far is not called held."""
        if self.status == "not applicable":
            return self
        return replace(self, status="not tested after" if self.status == "held" else self.status, until=until)

    @property
    def short(self) -> str:
        """For a cell of a table."""
        share = tick_share(self.key, self.broken, self.checked)
        causes = list(self.causes) if sum(self.causes.values()) == self.broken else []
        return verdict_text(self.key, self.status, self.first_time, self.amount, share, causes, self.until)


def verdict_text(
    key: str, status: str, first_time: float, amount: float, share: str, causes: Sequence[str], until: float
) -> str:
    """A verdict for a cell of a table.

    Args:
        key: Key of `STATEMENTS`.
        status: One of `STATUSES`.
        first_time: When it was first broken, s.
        amount: By how much at worst.
        share: See `tick_share`; empty where it says nothing.
        causes: Its causes, names of `CAUSES`, where these are all; else empty.
        until: When the run ended by diverging, s; NaN if it did not.
    """
    if status == "not tested after":
        return f"not tested after {until:.4g} s, where it diverged; not broken before"
    if status != "broken":
        return status
    of = STATEMENTS[key].unit
    by = f" by {' and '.join(causes)}" if causes else ""
    text = f"broken{by} at {first_time:.4g} s, up to {amount:.3g}{'' if of == '1' else f' {of}'} over{share}"
    return text if np.isnan(until) else f"{text}; not tested after {until:.4g} s, where it diverged"


def tick_share(key: str, broken: int, checked: int) -> str:
    """In how many of which ticks a claim is broken, to follow the rest; empty where it is checked but once."""
    if checked <= 1:
        return ""
    return f", in {broken} of {checked} {STATEMENTS[key].ticks} ({percent(broken / checked)})"


def percent(share: float) -> str:
    """A share in percent with two digits, never 0 or 100 % unless it is."""
    text = f"{100.0 * share:.2g}"
    return f"{'99.9' if text == '1e+02' and share < 1.0 else '100' if share == 1.0 else text} %"


def not_applicable(key: str, trial: int, reason: str) -> Claim:
    """A claim that says nothing about this law."""
    return Claim(key, trial, "not applicable", reason=reason)


def judge(
    key: str,
    trial: int,
    time: Array,
    excess: Array,
    checked: BoolArray,
    causes: IntArray | None,
    held: str,
    untested: str,
    broken: str,
) -> Claim:
    """A claim of the form "excess ≤ 0 wherever checked".

    Args:
        key: Key of `STATEMENTS`.
        trial: Index of the trial.
        time: Shape (T,), s.
        excess: Shape (T,), round-off taken off already.
        checked: Where it is claimed, shape (T,), bool.
        causes: Index in `CAUSES` of each tick, shape (T,), −1 for none of them; None where none ever is.
        held: What to say if it held.
        untested: What to say if there is nothing to check.
        broken: What to say first if it is broken.
    """
    ticks = int(np.sum(checked))
    if ticks == 0:
        return Claim(key, trial, "not tested", reason=untested)
    over = checked & (excess > 0.0)
    count = int(np.sum(over))
    if count == 0:
        return Claim(key, trial, "held", checked=ticks, reason=held)
    worst = int(np.argmax(np.where(over, excess, -np.inf)))
    counted: dict[str, int] = {}
    if causes is not None:
        counted = {name: int(np.sum(over & (causes == i))) for i, name in enumerate(CAUSES)}
        counted = {name: value for name, value in counted.items() if value}
    listed = ", ".join(f"{name} in {value} of {count} ticks" for name, value in counted.items())
    return Claim(
        key,
        trial,
        "broken",
        checked=ticks,
        broken=count,
        first_time=float(time[np.argmax(over)]),
        worst_time=float(time[worst]),
        amount=float(excess[worst]),
        causes=counted,
        reason="; ".join(part for part in (listed, broken) if part),
    )


def weigh(parts: Mapping[str, Array], window: slice) -> int:
    """Which cause, as an index in `CAUSES`, added most over a window of ticks; each part of shape (T,)."""
    return int(np.argmax([float(np.nansum(parts[name][window])) for name in CAUSES]))
