"""What a verdict on M̄ is about: a theorem without its hypotheses is no theorem.

One object and one wording for `verify`, `design` and `check`, in text, JSON and pages. Nothing heavy is imported here:
who checks a certificate by another route uses it too.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, TypeAlias

from asmc_pin.words.choices import Condition as Condition
from asmc_pin.words.joint_units import joint_units, listed_with_units
from asmc_pin.words.provisos import Proviso as Proviso
from asmc_pin.words.provisos import provisos_json
from asmc_pin.words.text import exact, printable, quoted, rounded_down, rounded_up, visible

Interval: TypeAlias = tuple[float, float]

NAMES: dict[Condition, str] = {"lemma1": "Lemma 1", "weighted": "The weighted condition"}

Where: TypeAlias = Literal["box", "motion", "tube", "boxes"]


_FEW_LOCKS = 4
"""So many locked joints stand in a headline one by one."""

WHOLE_TURN = 2.0 * math.pi * (1.0 - 1e-12)
"""From this range on, rad, the ends of a joint's range are the same configuration, up to rounding."""


def formula(condition: Condition, level: float = 1.0) -> str:
    """A condition as an inequality, at a level γ of its norm."""
    norm = {"lemma1": "‖I − M⁻¹M̄‖₂", "weighted": "max|1 − λ(M⁻¹M̄)|"}[condition]
    if level < 1.0:
        return f"{norm} < {level!r}"
    return f"{norm} < 1" if condition == "lemma1" else f"{norm} < 1, i.e. M̄ ≺ 2M"


@dataclass(frozen=True)
class Carried:
    """A payload, or the range of it that lies between two.

    Attributes:
        mass: kg; a value, or (lightest, heaviest).
        link: The link that carries it.
        com: Centre of mass in the link's frame, m; each coordinate a value, the same over all masses, or a range.
        inertia: ixx, ixy, ixz, iyy, iyz, izz about that centre, kg·m²; over a range that of the heaviest, while the
            lightest has `inertia_lightest` and what is between lies on the line between them.
        inertia_lightest: None without a range.
    """

    mass: float | Interval
    link: str
    com: tuple[float | Interval, ...]
    inertia: tuple[float, ...]
    inertia_lightest: tuple[float, ...] | None = None

    def to_json_dict(self) -> dict[str, Any]:
        """``mass``, ``link``, ``com``, and the inertia where it is not a point mass."""
        content: dict[str, Any] = {
            "mass": _plain(self.mass),
            "link": printable(self.link),
            "com": [_plain(x) for x in self.com],
        }
        if any(self.inertia) or any(self.inertia_lightest or ()):
            content["inertia"] = list(self.inertia)
            if self.inertia_lightest is not None:
                content["inertia_lightest"] = list(self.inertia_lightest)
        return content

    def words(self) -> str:
        """The same for a person to read."""
        at = ", ".join(_words(x) for x in self.com)
        said = f"{_words(self.mass)} kg at ({at}) m on {quoted(self.link)}"
        if any(isinstance(x, tuple) for x in self.com):
            said += (
                " (of each range of its place the ends and the middle are searched; what is proven holds between too)"
            )
        if any(self.inertia) or any(self.inertia_lightest or ()):
            said += f", inertia about its centre ({', '.join(f'{exact(x)}' for x in self.inertia)}) kg·m²"
            if self.inertia_lightest is not None:
                lightest = ", ".join(f"{exact(x)}" for x in self.inertia_lightest)
                said += f" where heaviest, ({lightest}) where lightest"
        return said


@dataclass(frozen=True, kw_only=True)
class Premises:
    """The arm that a statement is about, with all that is assumed of it, and the configurations that are covered.

    Attributes:
        arm: Name of the arm.
        sha256: Hash of its URDF.
        joints: Its moving joints, base first.
        slides: Which of them are prismatic.
        armature: Reflected rotor inertia per joint, kg·m² (kg where prismatic); a value or a range.
        payload: What the arm carries; None for nothing.
        locked: Joints held rigid, each at an angle or at each of several, rad (m where prismatic).
        together: Whether several angles of several joints go first with first, second with second, and not each with
            each; see `fold_locks`.
        box: The range of each joint, rad (m where prismatic).
        where: ``box``: all of `box`. ``motion``: the configurations of a motion, whose range is `box`. ``tube``: joint
            boxes around one motion's time slices, whose common range is `box`. ``boxes``: joint boxes, of which nothing
            else is known.
        parts: How many such boxes.
        boxes: These, where it is more than one and they are known: lower and upper ends, each one per joint.
        provisos: In what the arm is not as its file says.
        mimics: Joints that follow one of `joints`: name to (joint, multiplier, offset).
        elsewhere: Joints after a whole turn of which what follows them is elsewhere.
    """

    arm: str
    sha256: str
    joints: tuple[str, ...]
    slides: tuple[bool, ...]
    armature: tuple[float | Interval, ...]
    payload: Carried | None
    locked: Mapping[str, float | tuple[float, ...]]
    box: Mapping[str, Interval]
    where: Where = "box"
    parts: int = 1
    together: bool = False
    boxes: tuple[tuple[tuple[float, ...], tuple[float, ...]], ...] = field(default=(), repr=False)
    provisos: tuple[Proviso, ...] = ()
    mimics: Mapping[str, tuple[str, float, float]] = field(default_factory=dict)
    elsewhere: tuple[str, ...] = ()

    @property
    def title(self) -> str:
        """The arm's name with all that is supposed about it, so that no headline is a theorem about the bare arm."""
        supposed = list(dict.fromkeys(proviso.kind for proviso in self.provisos if proviso.headline))
        if any(self.armature):
            supposed.append(f"armature {self._armature()}")
        if self.payload is not None:
            supposed.append(f"payload {_words(self.payload.mass)} kg")
        if self.locked:
            # The rows have them all; a headline with forty names says nothing any more.
            few = len(self.locked) <= _FEW_LOCKS
            supposed.append(f"{self._locks()} locked" if few else f"{len(self.locked)} joints locked")
        return quoted(self.arm) + (f" with {', '.join(supposed)}" if supposed else "")

    def to_json_dict(self) -> dict[str, Any]:
        """The keys of ``verify --json`` that are about the arm; names without control characters."""
        content: dict[str, Any] = {
            "arm": printable(self.arm),
            "sha256": self.sha256,
            "joints": [printable(name) for name in self.joints],
            "armature": [_plain(value) for value in self.armature],
            "payload": None if self.payload is None else self.payload.to_json_dict(),
            "locked": {printable(name): _plain(value) for name, value in self.locked.items()},
        }
        if self.provisos:
            content["provisos"] = provisos_json(self.provisos)
        if self.together:
            content["locked_together"] = True
        if self.mimics:
            content["mimics"] = {
                printable(name): {"joint": printable(joint), "multiplier": multiplier, "offset": offset}
                for name, (joint, multiplier, offset) in self.mimics.items()
            }
        box = {printable(name): list(ends) for name, ends in self.box.items()}
        content |= {"box": box, "scope": self.where}
        if self.boxes:
            content["boxes"] = [
                {printable(name): [lo, hi] for name, lo, hi in zip(self.joints, *ends, strict=True)}
                for ends in self.boxes
            ]
        return content

    def rows(self) -> list[tuple[str, str]]:
        """Terms and what they are, for a page or a terminal."""
        over = {
            "box": "Joint box",
            "motion": "Along a motion within",
            "tube": f"In {self.parts} joint boxes along a motion, all within",
            "boxes": f"In {self.parts} joint boxes, and not between them, all within",
        }[self.where]
        moving = f"{len(self.joints)} moving joint{'s' if len(self.joints) > 1 else ''}"
        return [
            ("Arm", f"{quoted(self.arm)}, {moving} (URDF {self.sha256[:16]}…)"),
            ("Armature", self._armature()),
            ("Payload", "none" if self.payload is None else self.payload.words()),
            ("Locked joints", self._locks("; ") or "none"),
            *((proviso.kind[:1].upper() + proviso.kind[1:], visible(proviso.text)) for proviso in self.provisos),
            *([("Mimicking joints", self._mimics())] if self.mimics else []),
            (over, self._box()),
            *([("Whole turns", self._whole_turns())] if self.where == "box" and self.turning else []),
        ]

    @property
    def turning(self) -> tuple[str, ...]:
        """Joints whose range is a whole turn: continuous, of no declared limits, or of a turn and more."""
        joints = zip(self.box.items(), self.slides, strict=True)
        wide = tuple(name for (name, (lo, hi)), slides in joints if not slides and hi - lo >= WHOLE_TURN)
        return tuple(name for name in wide if name not in self.elsewhere)

    def lines(self) -> list[str]:
        """The same as lines of text."""
        return [f"{term}: {text}" for term, text in self.rows()]

    def _mimics(self) -> str:
        said = [
            f"{quoted(name)} = {exact(multiplier)} · {quoted(joint)}" + (f" + {exact(offset)}" if offset else "")
            for name, (joint, multiplier, offset) in self.mimics.items()
        ]
        return "; ".join(said)

    def _armature(self) -> str:
        if not any(self.armature):
            return "none"
        said = [_words(value) for value in self.armature]
        units = joint_units("inertia", self.slides)
        if len(set(said)) == len(set(units)) == 1:
            return f"{said[0]} {units[0]}" + (" at every joint" if len(said) > 1 else "")
        return listed_with_units(said, "inertia", self.slides)

    def _box(self) -> str:
        units = joint_units("place", self.slides)
        # A box is what a statement is about, to its last digit; a motion's ends only say within what it went.
        low, high = (rounded_down, rounded_up) if self.where == "motion" else (exact, exact)
        said = [f"{low(lo)}:{high(hi)} {unit}" for (lo, hi), unit in zip(self.box.values(), units, strict=True)]
        if len(set(said)) == 1 and len(said) > 1:
            return f"{said[0]} at every joint"
        return ", ".join(f"{quoted(name)} {ends}" for name, ends in zip(self.box, said, strict=True))

    def _whole_turns(self) -> str:
        names = "every joint" if len(self.turning) == len(self.joints) > 1 else ", ".join(map(quoted, self.turning))
        return f"{names}: a range of a turn or more is taken as one turn, which loses nothing: M(q) repeats after 2π"

    def _locks(self, separator: str = ", ") -> str:
        said = separator.join(f"{quoted(name)} at {_choices(angles)}" for name, angles in self.locked.items())
        return f"{said} (first with first, and so on)" if self.together else said


@dataclass(frozen=True, kw_only=True)
class Hypotheses(Premises):
    """All that a verdict on M̄ rests on.

    Attributes:
        condition: ``lemma1`` or ``weighted``.
        mbar: Diagonal of M̄, kg·m² (kg where prismatic); empty where one was looked for and there is none.
        level: γ of the norm that the verdict is about; 1 is the condition itself.
    """

    condition: Condition
    mbar: tuple[float, ...]
    level: float = 1.0

    @property
    def formula(self) -> str:
        """The condition as an inequality, its level included."""
        return formula(self.condition, self.level)

    def to_json_dict(self) -> dict[str, Any]:
        """The keys of ``verify --json`` that are hypotheses; names without control characters."""
        about = super().to_json_dict()
        first = {key: about.pop(key) for key in ("arm", "sha256", "joints")}
        mbar = list(self.mbar) or None
        return first | {"mbar": mbar} | about | {"condition": self.condition, "level": self.level}

    def rows(self) -> list[tuple[str, str]]:
        """Terms and what they are, for a page or a terminal."""
        arm, *others = super().rows()
        found = [arm, ("Condition", f"{NAMES[self.condition]}: {self.formula}")]
        if self.mbar:
            found.append(("M̄", f"diag{listed_with_units([exact(m) for m in self.mbar], 'inertia', self.slides)}"))
        return found + others


def scaling_words(scaling: Sequence[float]) -> str:
    """A diagonal scaling of the joints, q̇ = S x, for a person to read."""
    if all(s == 1.0 for s in scaling):
        return "none (S = I)"
    return f"S = diag({', '.join(exact(s) for s in scaling)}), q̇ = S x"


def fold_locks(choices: Sequence[Mapping[str, float]]) -> tuple[dict[str, float | tuple[float, ...]], bool]:
    """The locked joints of several arms in one mapping.

    Args:
        choices: Joint to angle, of each arm; all of the same joints.

    Returns:
        Joint to its angle, or to each of its several; and whether these go together (first with first) because not
        every combination of them is among the arms.
    """
    distinct = list({tuple(sorted(choice.items())): choice for choice in choices}.values())
    seen = {name: tuple(dict.fromkeys(choice[name] for choice in distinct)) for name in distinct[0]}
    together = len(distinct) != math.prod(len(angles) for angles in seen.values())
    if together:
        seen = {
            name: angles if len(angles) == 1 else tuple(choice[name] for choice in distinct)
            for name, angles in seen.items()
        }
    return {name: angles[0] if len(angles) == 1 else angles for name, angles in seen.items()}, together


def _words(value: float | Interval) -> str:
    return f"{exact(value[0])} to {exact(value[1])}" if isinstance(value, tuple) else f"{exact(value)}"


def _choices(angles: float | tuple[float, ...]) -> str:
    return " and at ".join(f"{exact(a)}" for a in angles) if isinstance(angles, tuple) else f"{exact(angles)}"


def _plain(value: float | tuple[float, ...]) -> Any:
    return list(value) if isinstance(value, tuple) else value
