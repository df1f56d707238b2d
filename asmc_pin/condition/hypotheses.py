"""What a verdict on M̄ is about: a theorem without its hypotheses is no theorem.

One object and one wording for `verify`, `design` and `check`, in text, JSON and pages.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

from asmc_pin.choices import Condition as Condition
from asmc_pin.text import printable

Interval: TypeAlias = tuple[float, float]

NAMES: dict[Condition, str] = {"lemma1": "Lemma 1", "weighted": "The weighted condition"}

Where: TypeAlias = Literal["box", "motion", "tube", "boxes"]


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
        com: Centre of mass in the link's frame, m, the same over a range.
        inertia: ixx, ixy, ixz, iyy, iyz, izz about that centre, kg·m²; over a range that of the heaviest, while the
            lightest has `inertia_lightest` and what is between lies on the line between them.
        inertia_lightest: None without a range.
    """

    mass: float | Interval
    link: str
    com: tuple[float, ...]
    inertia: tuple[float, ...]
    inertia_lightest: tuple[float, ...] | None = None

    def to_json_dict(self) -> dict[str, Any]:
        """``mass``, ``link``, ``com``, and the inertia where it is not a point mass."""
        content: dict[str, Any] = {
            "mass": _plain(self.mass),
            "link": printable(self.link),
            "com": list(self.com),
        }
        if any(self.inertia) or any(self.inertia_lightest or ()):
            content["inertia"] = list(self.inertia)
            if self.inertia_lightest is not None:
                content["inertia_lightest"] = list(self.inertia_lightest)
        return content

    def words(self) -> str:
        """The same for a person to read."""
        at = ", ".join(f"{x:g}" for x in self.com)
        said = f"{_words(self.mass)} kg at ({at}) m on {printable(self.link)}"
        if any(self.inertia):
            said += f", inertia about its centre ({', '.join(f'{x:g}' for x in self.inertia)}) kg·m²"
            if self.inertia_lightest is not None:
                lightest = ", ".join(f"{x:g}" for x in self.inertia_lightest)
                said += f" where heaviest, ({lightest}) where lightest"
        return said


@dataclass(frozen=True, kw_only=True)
class Hypotheses:
    """All that a verdict on M̄ rests on.

    Attributes:
        arm: Name of the arm.
        sha256: Hash of its URDF.
        joints: Its moving joints, base first.
        slides: Which of them are prismatic.
        condition: ``lemma1`` or ``weighted``.
        formula: The condition as an inequality, its level included.
        mbar: Diagonal of M̄, kg·m².
        armature: Reflected rotor inertia per joint, kg·m² (kg where prismatic); a value or a range.
        payload: What the arm carries; None for nothing.
        locked: Joints held rigid, each at an angle or at each of several, rad (m where prismatic).
        box: The range of each joint, rad (m where prismatic).
        where: ``box``: all of `box`. ``motion``: the configurations of a motion, whose range is `box`. ``tube``: joint
            boxes around one motion's time slices, whose common range is `box`. ``boxes``: joint boxes, of which nothing
            else is known.
        parts: How many such boxes.
        boxes: These, where it is more than one and they are known: lower and upper ends, each one per joint.
    """

    arm: str
    sha256: str
    joints: tuple[str, ...]
    slides: tuple[bool, ...]
    condition: Condition
    formula: str
    mbar: tuple[float, ...]
    armature: tuple[float | Interval, ...]
    payload: Carried | None
    locked: Mapping[str, float | tuple[float, ...]]
    box: Mapping[str, Interval]
    where: Where = "box"
    parts: int = 1
    boxes: tuple[tuple[tuple[float, ...], tuple[float, ...]], ...] = ()

    def to_json_dict(self) -> dict[str, Any]:
        """The keys of ``verify --json`` that are hypotheses; names without control characters."""
        content = {
            "arm": printable(self.arm),
            "sha256": self.sha256,
            "joints": [printable(name) for name in self.joints],
            "mbar": list(self.mbar),
            "armature": [_plain(value) for value in self.armature],
            "payload": None if self.payload is None else self.payload.to_json_dict(),
            "locked": {printable(name): _plain(value) for name, value in self.locked.items()},
            "box": {printable(name): list(ends) for name, ends in self.box.items()},
            "scope": self.where,
            "condition": self.condition,
        }
        if self.boxes:
            content["boxes"] = [
                {printable(name): [lo, hi] for name, lo, hi in zip(self.joints, *ends, strict=True)}
                for ends in self.boxes
            ]
        return content

    def rows(self) -> list[tuple[str, str]]:
        """Terms and what they are, for a page or a terminal."""
        units = ["m" if slides else "rad" for slides in self.slides]
        ranges = (
            f"{printable(name)} {lo:.10g}:{hi:.10g} {unit}"
            for (name, (lo, hi)), unit in zip(self.box.items(), units, strict=True)
        )
        over = {
            "box": "Joint box",
            "motion": "Along a motion within",
            "tube": f"In {self.parts} joint boxes along a motion, all within",
            "boxes": f"In {self.parts} joint boxes, and not between them, all within",
        }[self.where]
        return [
            ("Arm", f"{printable(self.arm)}, {len(self.joints)} moving joints (URDF {self.sha256[:16]}…)"),
            ("Condition", f"{NAMES[self.condition]}: {self.formula}"),
            ("M̄", f"diag({', '.join(f'{m:.10g}' for m in self.mbar)}) kg·m²"),
            ("Armature", _all_same(self.armature)),
            ("Payload", "none" if self.payload is None else self.payload.words()),
            (
                "Locked joints",
                "; ".join(f"{printable(name)} at {_choices(angles)}" for name, angles in self.locked.items()) or "none",
            ),
            (over, ", ".join(ranges)),
        ]

    def lines(self) -> list[str]:
        """The same as lines of text."""
        return [f"{term}: {text}" for term, text in self.rows()]


def _all_same(values: Sequence[float | Interval]) -> str:
    if all(value == 0.0 for value in values):
        return "none"
    said = [_words(value) for value in values]
    return f"{said[0]} kg·m² at every joint" if len(set(said)) == 1 else f"{', '.join(said)} kg·m²"


def _words(value: float | Interval) -> str:
    return f"{value[0]:g} to {value[1]:g}" if isinstance(value, tuple) else f"{value:g}"


def _choices(angles: float | tuple[float, ...]) -> str:
    return " and at ".join(f"{a:g}" for a in angles) if isinstance(angles, tuple) else f"{angles:g}"


def _plain(value: float | tuple[float, ...]) -> Any:
    return list(value) if isinstance(value, tuple) else value
