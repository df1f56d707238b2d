"""The parts of a certificate's header, as a strict schema: finite numbers, closed enumerations, sizes that agree."""

from __future__ import annotations

import math
import re
from typing import Annotated, Literal

import numpy as np
from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    FailFast,
    Field,
    model_validator,
)

from asmc_pin.words.text import printable, visible

_ROUNDED = 1e-9
"""Of a payload's largest principal moment: digits that somebody may have rounded."""

_LARGEST = 1e30
"""Of what is given in hexadecimal, in SI units; what is larger measures nothing, and its square may be no float."""

_HEX = re.compile(r"-?0x[01]\.?[0-9a-f]{0,13}p[+-][0-9]{1,4}")


FARTHEST = 1e4
"""Largest angle, rad, or slide, m: far from zero floats lie too far apart for what is done with angles."""


class Malformed(ValueError):
    """The header is not one of a certificate; the message says where and why."""


def _from_hex(value: object) -> float:
    if not isinstance(value, str) or not _HEX.fullmatch(value):
        raise ValueError("a hexadecimal float expected")
    try:
        number = float.fromhex(value)
    except OverflowError:
        number = math.inf
    if abs(number) > _LARGEST:
        raise ValueError(f"a number of at most {_LARGEST:g} expected")
    return number


def _shown(name: str) -> str:
    if name != printable(name):
        raise ValueError("a name that can be shown as it is expected")
    return name


def _seen_whole(text: str) -> str:
    if text != visible(text):
        raise ValueError("a text that can be shown as it is expected")
    return text


Hex = Annotated[float, BeforeValidator(_from_hex)]
Row = Annotated[tuple[Hex, ...], Field(min_length=1, max_length=64)]
Name = Annotated[str, Field(min_length=1, max_length=1000), AfterValidator(_shown)]
Angle = Annotated[Hex, Field(ge=-FARTHEST, le=FARTHEST)]
Angles = Annotated[tuple[Angle, ...], Field(min_length=1, max_length=64)]
Figure = Annotated[float, Field(allow_inf_nan=False)]
Text = Annotated[str, Field(max_length=100_000)]
Index = Annotated[int, Field(ge=0, lt=100_000)]


class Part(BaseModel):
    """Strictly what it says, and nothing else."""

    model_config = ConfigDict(strict=True, extra="forbid", frozen=True)


class Load(Part):
    """A payload: kg, m in the link's frame, kg·m² about the centre (ixx, ixy, ixz, iyy, iyz, izz)."""

    mass: Annotated[Hex, Field(ge=0.0)]
    com: tuple[Hex, Hex, Hex]
    inertia: tuple[Hex, Hex, Hex, Hex, Hex, Hex]
    link: Name

    @model_validator(mode="after")
    def _of_a_body(self) -> Load:
        """No body has a principal moment that is negative or more than the sum of the other two."""
        xx, xy, xz, yy, yz, zz = self.inertia
        moments = np.linalg.eigvalsh(np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]))
        allowed = _ROUNDED * float(np.abs(moments).max())
        possible = moments[0] >= -allowed and moments[0] + moments[1] >= moments[2] - allowed
        if not possible or (self.mass == 0.0 and any(self.inertia)):
            raise ValueError("a payload has an inertia that no rigid body has")
        return self


class WrittenCase(Part):
    """One arm and joint box of those that the statements speak of."""

    label: Text
    locked: dict[Name, Angle]
    payload: Load | None
    lower: Angles
    upper: Angles
    armature_lower: Row
    armature_upper: Row
    sample_q: Annotated[tuple[Angles, ...], Field(min_length=1, max_length=64)]
    sample_mass: Annotated[tuple[tuple[Row, ...], ...], Field(min_length=1, max_length=64)]

    @property
    def load(self) -> Load | None:
        """What is carried; a payload without mass is none."""
        return self.payload if self.payload is not None and self.payload.mass > 0.0 else None


class WrittenStatement(Part):
    """One positivity statement; see docs/certificate.md.

    Where joints follow others, `weights` has for each piece of its box what every joint of the branch bears of m̄.
    """

    kind: Literal["weighted", "bounded", "lemma1", "level"]
    scale: Annotated[Figure, Field(gt=0.0)]
    level: Annotated[Figure, Field(gt=0.0, le=1.0)]
    case: Index
    armature: Row
    slack: Row
    weights: tuple[Row, ...] = ()

    @model_validator(mode="after")
    def _of_its_kind(self) -> WrittenStatement:
        """A level of one is the condition itself, which two of the kinds are and two are not."""
        if self.kind == "lemma1" and self.level != 1.0:
            raise ValueError("a statement 'lemma1' has the level 1")
        if self.kind in ("bounded", "level") and self.level >= 1.0:
            raise ValueError(f"a statement '{self.kind}' has a level below 1")
        if self.kind not in ("bounded", "level") and any(self.slack):
            raise ValueError(f"a statement '{self.kind}' needs no slack of the armature")
        if min(self.armature) < 0.0 or min(self.slack) < 0.0:
            raise ValueError("armature and its slack are 0 or more")
        return self


class Seen(Part):
    """A configuration with its case and armature."""

    case: Index
    q: Angles
    armature: Row


class WrittenProviso(Part):
    """In what the arm is not as the file that its maker read; no statement rests on it."""

    kind: Name
    text: Annotated[str, Field(min_length=1, max_length=100_000), AfterValidator(_seen_whole)]


class Header(Part):
    """What every header says. `arm`, `source`, `sha256` and the labels are its maker's words and are not used.

    Nor do statements rest on `provisos`, which are repeated as its maker's words. `moving` names all joints that move,
    where some of them follow those of `joints`.
    """

    format: Text
    arm: Text
    source: Text
    sha256: Text
    urdf_sha256: Text
    joints: Annotated[tuple[Name, ...], Field(min_length=1, max_length=64)]
    moving: Annotated[tuple[Name, ...], Field(max_length=64)] = ()
    provisos: tuple[WrittenProviso, ...] = ()
    mbar: tuple[Annotated[Hex, Field(gt=0.0)], ...]
    # The first bad one is enough: a message for each of many costs more than the file.
    cases: Annotated[tuple[WrittenCase, ...], Field(min_length=1), FailFast()]
    statements: Annotated[tuple[WrittenStatement, ...], FailFast()]
    digest: Text

    @property
    def seen(self) -> tuple[Seen, Seen]:
        """The two configurations that it shows."""
        raise NotImplementedError

    @property
    def kinds(self) -> set[str]:
        """The statements that say something about what it is about."""
        return {"weighted", "bounded"}

    @model_validator(mode="after")
    def _sizes_agree(self) -> Header:
        """A number per joint everywhere, indices of cases that are there, ranges that are not empty."""
        n = len(self.joints)
        if len(set(self.joints)) != n:
            raise ValueError("two of the joints have one name")
        if self.moving and not (set(self.joints) < set(self.moving) and len(set(self.moving)) == len(self.moving)):
            raise ValueError("the joints that move are not each once those with a coordinate and more")
        if not self.moving and any(statement.weights for statement in self.statements):
            raise ValueError("weights of joints where none follows another")
        rows = [self.mbar, *(row for seen in self.seen for row in (seen.q, seen.armature))]
        for case in self.cases:
            rows += [case.lower, case.upper, case.armature_lower, case.armature_upper, *case.sample_q]
            rows += [row for mass in case.sample_mass for row in mass]
            if len(case.sample_q) != len(case.sample_mass) or any(len(mass) != n for mass in case.sample_mass):
                raise ValueError("a sample of the inertia matrix has another size than the arm")
            if any(a > b for a, b in zip(case.lower, case.upper, strict=False)):
                raise ValueError("a joint box is empty")
            if any(not 0.0 <= a <= b for a, b in zip(case.armature_lower, case.armature_upper, strict=False)):
                raise ValueError("a range of the armature is empty or negative")
        for statement in self.statements:
            rows += [statement.armature, statement.slack]
        if any(len(row) != n for row in rows):
            raise ValueError(f"a row has not one number for each of the {n} joints")
        named = [*(seen.case for seen in self.seen), *(statement.case for statement in self.statements)]
        if max(named) >= len(self.cases):
            raise ValueError("a case is named that is not there")
        if not {statement.kind for statement in self.statements} <= self.kinds:
            raise ValueError("a statement is of a kind that says nothing about what the certificate is about")
        return self
