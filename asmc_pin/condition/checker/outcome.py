"""What replaying a certificate came to."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from asmc_pin.condition.checker.bounds_conclusion import BoundsConclusion
from asmc_pin.condition.checker.conclusions import Conclusion
from asmc_pin.condition.checker.loop_conclusion import LoopConclusion
from asmc_pin.condition.checker.spot_checks import Spots
from asmc_pin.condition.hypotheses import Hypotheses, Premises
from asmc_pin.words.text import counted, printable, rounded_down, rounded_up, visible


@dataclass(frozen=True)
class CheckedStatement:
    """One statement of a certificate.

    Attributes:
        kind: As in docs/certificate.md: ``weighted``, ``bounded``, ``lemma1``, ``level``.
        scale: f.
        level: γ.
        case: Which of the arms, in words; empty where there is one.
        boxes: Leaves of its bisection.
        halved: How many more this route needed.
        proven: Whether all are proven.
        spots: What was put to the condition in ball arithmetic.
    """

    kind: str
    scale: float
    level: float
    case: str
    boxes: int
    halved: int
    proven: bool
    spots: Spots

    def to_json_dict(self) -> dict[str, Any]:
        """For ``asmc-pin check --json``."""
        return {**self.__dict__, "spots": {k: v for k, v in self.spots.__dict__.items() if k != "problem"}}


@dataclass(frozen=True, repr=False)
class CheckResult:
    """The outcome of checking a certificate; all of it is derived from the arm and the statements inside.

    Attributes:
        path: The file.
        valid: Whether all its statements were proven again and all that it claims follows from them.
        problems: Why not, one sentence each.
        hypotheses: What the statements are about; None where it is not valid.
        conclusion: What they come to; None where it is not valid.
        statements: Its statements.
        seconds: Wall time.
    """

    path: str
    valid: bool
    problems: tuple[str, ...]
    hypotheses: Premises | None
    conclusion: Conclusion | BoundsConclusion | LoopConclusion | None
    statements: tuple[CheckedStatement, ...]
    seconds: float

    @property
    def verdict(self) -> str | None:
        """``holds``, ``violated`` or ``undecided``, of a loop ``stable`` or ``unstable``; None if it is not valid."""
        return None if self.conclusion is None else self.conclusion.verdict

    # As of `asmc_pin.words.shown.Shown`, which a checker that shares nothing does not share either.
    def __str__(self) -> str:
        return "\n".join(map(visible, self.lines()))

    def __repr__(self) -> str:
        return f"<CheckResult: {visible(self.lines()[0])}>"

    def to_json_dict(self) -> dict[str, Any]:
        """The object that ``asmc-pin check --json`` prints: what is not derived is None."""
        about = dict.fromkeys(
            ("arm", "sha256", "joints", "mbar", "armature", "payload", "locked", "box", "scope", "condition")
        )
        shown = dict.fromkeys(("verdict", "lower", "upper", "scale_proven", "scale_refuted"))
        return {
            "path": printable(self.path),
            "valid": self.valid,
            "problems": list(self.problems),
            **(about if self.hypotheses is None else self.hypotheses.to_json_dict()),
            **(shown if self.conclusion is None else self.conclusion.to_json_dict()),
            "kind": "certified",
            "statements": [statement.to_json_dict() for statement in self.statements],
            "seconds": self.seconds,
        }

    def lines(self) -> list[str]:
        """The same for a person to read."""
        found = [f"{printable(self.path)}: {'valid' if self.valid else 'NOT VALID: it proves nothing'}"]
        found += [f"problem: {problem}" for problem in self.problems]
        if self.conclusion is not None and self.hypotheses is not None:
            found += self.conclusion.lines()
            if isinstance(self.hypotheses, Hypotheses) and self.hypotheses.level < 1.0:
                found.append(f"the verdict is about {self.hypotheses.formula}, the scales are about the norm below 1")
            found += self.hypotheses.lines()
        found += [_line(statement) for statement in self.statements]
        if self.statements:
            points = sum(s.spots.points for s in self.statements)
            boxes = sum(s.spots.boxes for s in self.statements)
            widths = [w for s in self.statements if s.spots.widths is not None for w in s.spots.widths]
            size = f" (half widths {min(widths):.2g} to {max(widths):.2g})" if widths else ""
            found.append(
                f"  in ball arithmetic, from the URDF's decimals: {counted(points, 'configuration')} of them, and "
                f"{counted(boxes, 'small box', 'small boxes')} in them{size}, satisfy their statements"
            )
        return [*found, f"  {self.seconds:.1f} s"]


def _line(s: CheckedStatement) -> str:
    where = f" ({s.case})" if s.case else ""
    cover = "1 box covers" if s.boxes == 1 else f"{s.boxes} boxes cover"
    again = ("" if s.boxes == 1 else "all ") + "proven again"
    return (
        f"  {s.kind}, scale {rounded_down(s.scale)}, level {rounded_up(s.level)}{where}: {cover} the joint box, "
        f"{again if s.proven else f'not {again}'} ({s.halved} halved further)"
    )
