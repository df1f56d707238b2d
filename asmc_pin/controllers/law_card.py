"""A law on one page, from its class and from what its step reads: nothing here is about one law."""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass
from time import process_time
from typing import Any

import numpy as np

from asmc_pin.controllers.protocol import Sample, Setpoint
from asmc_pin.controllers.tde import TdeLaw
from asmc_pin.parameters import Parameter, parameters_of

READ = {
    "q": "angle q",
    "v": "velocity q̇",
    "torque": "torque applied over the last period, τ(t−L)",
    "q_ref": "q_d",
    "v_ref": "q̇_d",
    "a_ref": "q̈_d",
}
SHARED = {"mbar": 0.4, "ks": 8.0, "beta": 8.0, "period": 1e-3}
"""With which a law is asked; what it reads does not depend on them."""
VALUES = "  values to begin with: this project's own, by trial; two_link, ur5 and panda are held with them at 1 kHz"
"""Where the typical values on a card come from."""


@dataclass(frozen=True)
class CardParameter:
    """A parameter on a card: as in the tables, and a value to begin with."""

    name: str
    meaning: str
    unit: str
    takes: str
    typical: str


@dataclass(frozen=True)
class LawCard:
    """One law on a page.

    Attributes:
        name: Its name in experiments.
        title: What it is.
        equation: Its torque.
        parameters: Its own.
        reads: Keys of `READ` that reach its torque from the second tick on.
        remembers: Names of what its state holds.
        oracle: What it does exactly.
        claim: What its source claims.
        fails: When that does not hold.
        source: Where it is from.
        logged: Which s a run logs, and whether a gain.
    """

    name: str
    title: str
    equation: str
    parameters: tuple[CardParameter, ...]
    reads: tuple[str, ...]
    remembers: tuple[str, ...]
    oracle: str
    claim: str
    fails: str
    source: str
    logged: str

    def diagram(self) -> list[str]:
        """The law as a block: what goes in, what it remembers, what comes out."""
        told = [name for name in ("q_ref", "v_ref", "a_ref") if name in self.reads]
        seen = [name for name in ("q", "v", "torque") if name in self.reads]
        short = {"q": "q", "v": "q̇", "torque": "τ(t−L)", "q_ref": "q_d", "v_ref": "q̇_d", "a_ref": "q̈_d"}
        left = [", ".join(short[name] for name in names) for names in (told, seen)]
        inside = [self.name, f"remembers {', '.join(self.remembers) or 'nothing'}"]
        wide, deep = max(map(_width, left)), max(map(_width, inside))
        lines = [f"{' ' * wide}    ┌{'─' * (deep + 2)}┐"]
        for text, held, out in zip(left, inside, ("──> τ", ""), strict=True):
            lines.append(f"{' ' * (wide - _width(text))}{text} ──>│ {held}{' ' * (deep - _width(held))} │{out}")
        return [*lines, f"{' ' * wide}    └{'─' * (deep + 2)}┘"]

    def lines(self) -> list[str]:
        """The page as plain text."""
        needs = [READ[name] for name in ("q", "v", "torque") if name in self.reads]
        own = [
            f"  {item.name}: {item.meaning}{f' [{item.unit}]' if item.unit else ''}; {item.takes}; {item.typical}"
            for item in self.parameters
        ]
        return [
            f"{self.name}: {self.title}",
            "",
            self.equation,
            "",
            *self.diagram(),
            "",
            "Parameters of its own" + ("" if own else ": none"),
            *own,
            *([VALUES] if own else []),
            f"Needs measured: {', '.join(needs)}",
            f"Logged: {self.logged}",
            f"Exactly: {self.oracle}",
            f"Claim: {self.claim}",
            f"Fails: {self.fails}",
            f"Source: {self.source}",
        ]


def law_card(name: str, law: type[TdeLaw]) -> LawCard:
    """The card of a law of the package, with the values that it suggests."""
    return card_of(name, suggested(law), 1, parameters_of(TdeLaw))


def card_of(name: str, made: Any, nv: int, shared: Collection[str]) -> LawCard:
    """The card of a law, one that knows a model too.

    Args:
        name: Its name in experiments.
        made: The law with the values that its class suggests.
        nv: Number of joints to ask it about.
        shared: Names of the parameters that are not its own.
    """
    law = type(made)
    own = {key: item for key, item in parameters_of(law).items() if key not in shared}
    state = made.init(Sample(*(np.zeros((1, nv)) for _ in range(3))))
    gain = "and k̂, as `gain`" if hasattr(state, "gain") else "no gain"
    s = "s = ė + K_s e of (4)" if hasattr(made, "ks") else "no s"
    return LawCard(
        name,
        law.title,
        law.equation,
        tuple(_parameter(item, law) for item in own.values()),
        tuple(reads_of(made, nv)),
        tuple(_names(state)),
        law.oracle,
        law.claim,
        law.fails,
        law.reference,
        f"{s}; {gain}",
    )


def suggested(law: type[TdeLaw], **shared: Any) -> TdeLaw:
    """The law with the values that its card suggests; what all laws share may be given."""
    return law(**{**SHARED, **shared, **law.typical})


def reads_of(law: Any, nv: int = 1) -> list[str]:
    """Keys of `READ` that reach the torque of a law from the second tick on, found by changing one after the other."""
    rng = np.random.default_rng(3)
    ticks = 0.1 * rng.standard_normal((6, 6, 1, nv))
    usual = _torques(law, ticks)
    found = []
    for i, name in enumerate(READ):
        for change in (0.05, 50.0):  # a little, and beyond what a law may take for round-off or a limit
            changed = ticks.copy()
            changed[2:, i] += change
            if not np.array_equal(_torques(law, changed), usual):
                found.append(name)
                break
    return found


def cost_per_tick(law: Any, batch: int, nv: int = 6, seconds: float = 0.2) -> float:
    """Processor time that `step` takes per tick and trial on this machine, s: the best of a few rounds."""
    fields = 0.1 * np.random.default_rng(0).standard_normal((6, batch, nv))
    sample, setpoint = Sample(*fields[:3]), Setpoint(*fields[3:])
    state = law.step(law.init(sample), sample, setpoint)[1]
    best, end = np.inf, process_time() + seconds
    while process_time() < end:
        begin = process_time()
        for _ in range(20):
            law.step(state, sample, setpoint)
        best = min(best, (process_time() - begin) / (20 * batch))
    return float(best)


def _torques(law: Any, ticks: Any) -> Any:
    state = law.init(Sample(*ticks[0, :3]))
    torques = []
    for tick in ticks:
        torque, state = law.step(state, Sample(*tick[:3]), Setpoint(*tick[3:]))
        torques.append(torque[0])
    return np.array(torques)


def _parameter(item: Parameter[Any, Any], law: Any) -> CardParameter:
    value = law.typical.get(item.name)
    shown: Callable[[Any], str] = lambda x: f"{x:g}" if isinstance(x, float) else str(x)  # noqa: E731
    if value is not None:
        typical = f"begin with {shown(value)}"
    else:
        typical = "not given by default" if item.default is None else f"{shown(item.default)} by default"
    return CardParameter(item.name, item.meaning, item.unit, item.takes, typical)


def _names(state: Any) -> list[str]:
    """Names of the arrays of a state, those of nested ones in their place."""
    found: list[str] = []
    if state is None:
        return found
    for name, part in zip(state._fields, state, strict=True):
        if isinstance(part, tuple):
            found += _names(part)
        elif not isinstance(part, int):
            found.append(name)
    return found


def _width(text: str) -> int:
    """Columns of a text: combining signs take none."""
    import unicodedata

    return sum(1 for sign in text if not unicodedata.combining(sign))
