"""What follows from the statements of a certificate, once they are proven again, and from its two configurations.

The figures and the verdict that are printed are these; what the header says of itself has to agree with them.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any, Literal, TypeAlias

from asmc_pin.condition.checker.reading.certificate_schema import Contents
from asmc_pin.condition.checker.reading.header_parts import Header, Malformed, WrittenCase, WrittenStatement
from asmc_pin.words.text import rounded_down, rounded_up

Verdict: TypeAlias = Literal["holds", "violated", "undecided"]

_NEAR = 1e-6
"""How far the norm that the header gives may be from the one that is found at the same configuration."""


@dataclass(frozen=True)
class Witness:
    """What the two configurations show, in ball arithmetic.

    Attributes:
        lower: The condition's norm is nowhere below this over the boxes' worst; a float below the true value.
        at_level: Whether the norm there is at least the level that the verdict is about.
        refuted: Whether the condition is broken at the header's `scale_refuted` · M̄.
    """

    lower: float
    at_level: bool
    refuted: bool


@dataclass(frozen=True)
class Conclusion:
    """What the statements of a certificate show about M̄.

    Attributes:
        verdict: About M̄ itself, at the level of the header.
        lower: Largest norm shown.
        upper: Proven bound of the norm; 1 where just the condition is proven; None where nothing is.
        scale_proven: The condition is proven for M̄ times this and less; 0 for none.
        scale_refuted: A counter-example is shown for M̄ times this; None for none.
    """

    verdict: Verdict
    lower: float
    upper: float | None
    scale_proven: float
    scale_refuted: float | None

    def to_json_dict(self) -> dict[str, Any]:
        """The keys of ``check --json``."""
        return dict(self.__dict__)

    def lines(self) -> list[str]:
        """For a person to read, a line each."""
        scale = rounded_down(self.scale_proven)
        parts = [f"the condition is proven for M̄ × {scale}"] if self.scale_proven > 0.0 else []
        if self.scale_refuted is not None:
            parts.append(
                f"broken for M̄ × {rounded_up(self.scale_refuted)}"
                if self.scale_refuted > 0.0
                else "broken for every multiple of M̄"
            )
        parts.append(f"the norm is at least {rounded_down(self.lower)} at the worst configuration known")
        if self.upper is not None:
            parts.append(f"and proven to be below {rounded_up(self.upper)}")
        return [f"{self.verdict}: {', '.join(parts)}"]


def conclude(told: Contents, witness: Witness) -> Conclusion:
    """What follows from the statements, if all of them are true, and from the configurations."""
    scales, uppers = [], []
    by_case: list[list[WrittenStatement]] = [[] for _ in told.cases]
    for statement in told.statements:
        by_case[statement.case].append(statement)
    for own, case in zip(by_case, told.cases, strict=True):
        scale = _scale(told.condition, own, case)
        bounds = [1.0] if scale >= 1.0 else []
        level = _level(told.condition, own, case)
        uppers.append(min([*bounds, *([] if level is None else [level])], default=None))
        scales.append(scale)
    upper = None if any(bound is None for bound in uppers) else max(bound for bound in uppers if bound is not None)
    refuted = told.scale_refuted if witness.refuted else None
    verdict: Verdict = "undecided"
    if witness.at_level or (told.level == 1.0 and refuted is not None and refuted <= 1.0):
        verdict = "violated"
    elif upper is not None and upper <= told.level:
        verdict = "holds"
    return Conclusion(verdict, witness.lower, upper, min(scales), refuted)


def disagreements(told: Contents, found: Conclusion) -> list[str]:
    """Claims of the header that do not follow, a sentence each; and conclusions that contradict each other."""
    said = []
    if told.verdict != found.verdict:
        said.append(f"it says '{told.verdict}', and what is in it shows '{found.verdict}'")
    if told.scale_proven > found.scale_proven:
        said.append(f"nothing in the file proves the scale {told.scale_proven:.9g}")
    if told.upper is not None and (found.upper is None or told.upper < found.upper):
        said.append(f"nothing in the file proves that the norm is at most {told.upper:.9g}")
    if found.scale_refuted is None:
        said.append(f"the counter-example to the scale {told.scale_refuted:.9g} is none")
    elif found.scale_refuted <= (proven := max(found.scale_proven, 0.0 if found.upper is None else 1.0)) > 0.0:
        said.append(
            f"the scale {proven:.9g} is proven and {found.scale_refuted:.9g} refuted, which cannot both be: please "
            "report it"
        )
    if found.upper is not None and found.lower >= found.upper:
        said.append(
            f"the norm is {found.lower:.9g} at a configuration and proven to be below {found.upper:.9g}, which cannot "
            "both be: please report it"
        )
    if abs(found.lower - told.lower) > _NEAR * max(found.lower, 1.0):
        said.append(f"the norm at the worst configuration is {found.lower:.9g}, not {told.lower:.9g}")
    if not told.statements and found.verdict != "violated":
        said.append("it proves nothing and shows no violation")
    return said


def armature_words(told: Header, statement: WrittenStatement) -> str:
    """At which corner of its case's range of the armature a statement is proven; empty where it is the whole range.

    Raises:
        Malformed: It is about an armature, or a factor of M̄, that the certificate says nothing about.
    """
    case = told.cases[statement.case]
    low, high = case.armature_lower, case.armature_upper
    if isinstance(told, Contents) and statement.kind in ("bounded", "level") and statement.scale != 1.0:
        raise Malformed(f"a statement '{statement.kind}' is not about M̄ itself")
    whole = statement.armature == low
    if statement.kind in ("bounded", "level"):
        whole = whole and _below(high, _with_slack(statement))
    corner = all(a in ends for a, *ends in zip(statement.armature, low, high, strict=True))
    if not whole and not (statement.kind == "level" and corner and not any(statement.slack)):
        raise Malformed(f"a statement '{statement.kind}' is about another armature than the certificate")
    return "" if whole else f"armature {', '.join(f'{a!r}' for a in statement.armature)} kg·m²"


def _scale(condition: str, own: Sequence[WrittenStatement], case: WrittenCase) -> float:
    """The largest factor of M̄ at which the condition is proven over a case's range of the armature.

    Both conditions only gain by armature, so that the lower end covers the range.
    """
    kind = "weighted" if condition == "weighted" else "lemma1"
    proven = [s.scale for s in own if s.kind == kind and s.level == 1.0 and _below(s.armature, case.armature_lower)]
    return max(proven, default=0.0)


def _level(condition: str, own: Sequence[WrittenStatement], case: WrittenCase) -> float | None:
    """The least level of M̄ itself that is proven over a case's range of the armature; None for none."""
    at = [s for s in own if s.scale == 1.0]
    levels = sorted({s.level for s in at if s.level < 1.0})
    covers = _weighted_level if condition == "weighted" else _lemma1_level
    # What a level covers, every higher one does.
    first = bisect_left(levels, True, key=lambda level: covers([s for s in at if s.level <= level], case))
    return levels[first] if first < len(levels) else None


def _weighted_level(statements: Sequence[WrittenStatement], case: WrittenCase) -> bool:
    """M̄ ≺ (1 + γ) M at the least armature, and (1 − γ) M ≺ M̄ at the largest."""
    above = any(s.kind == "weighted" and covers_below(s, case) for s in statements)
    below = any(s.kind == "bounded" and covers_above(s, case) for s in statements)
    return above and below


def covers_below(statement: WrittenStatement, case: WrittenCase) -> bool:
    """Whether what is proven from below covers a case's range of the armature: more of it only adds to M."""
    return _below(statement.armature, case.armature_lower)


def covers_above(statement: WrittenStatement, case: WrittenCase) -> bool:
    """Whether what is proven from above covers it."""
    return _below(case.armature_upper, _with_slack(statement))


def _lemma1_level(statements: Sequence[WrittenStatement], case: WrittenCase) -> bool:
    """The whole range by one statement with its slack, or every corner by a statement of its own."""
    levels = [s for s in statements if s.kind == "level"]
    low, high = case.armature_lower, case.armature_upper
    if any(s.armature == low and _below(high, _with_slack(s)) for s in levels):
        return True
    ends = [(a,) if a == b else (a, b) for a, b in zip(low, high, strict=True)]
    proven = {s.armature for s in levels}
    # It ends at the first that is not there, so that not all of the 2ⁿ are listed.
    return all(corner in proven for corner in product(*ends))


def _below(a: Sequence[float], b: Sequence[float]) -> bool:
    return all(x <= y for x, y in zip(a, b, strict=True))


def _with_slack(statement: WrittenStatement) -> tuple[float, ...]:
    """The largest armature that a statement covers.

    Its slack was the upper end less the lower one, rounded; `quadratic_form.SLACKER` replays it with more than that.
    """
    return tuple((a + s) * (1.0 + 2.0**-51) for a, s in zip(statement.armature, statement.slack, strict=True))
