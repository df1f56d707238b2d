"""What an arm carries."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.arms.urdf.magnitudes import LENGTH
from asmc_pin.arms.urdf.rigid_inertia import inertia_problem
from asmc_pin.errors import ParameterError
from asmc_pin.words.text import as_number

_FIELDS = ("mass", "com", "inertia", "link")


@dataclass(frozen=True)
class Payload:
    """A rigid body fastened to a link.

    Attributes:
        mass: kg, zero or more.
        com: Centre of mass in the link's frame, m.
        inertia: ixx, ixy, ixz, iyy, iyz, izz about that centre, in the link's axes, kg·m². Zero makes it a point mass.
        link: The link that carries it; None is the child link of the arm's last moving joint.
    """

    mass: float
    com: tuple[float, float, float] = (0.0, 0.0, 0.0)
    inertia: tuple[float, float, float, float, float, float] = field(default=(0.0,) * 6)
    link: str | None = None

    def __post_init__(self) -> None:
        """Check sizes, signs and that the body is possible."""
        for name, size in (("mass", ()), ("com", (3,)), ("inertia", (6,))):
            try:
                value = np.asarray(getattr(self, name), dtype=np.float64)
            except (TypeError, ValueError, OverflowError):
                raise ParameterError(f"payload.{name}", f"{getattr(self, name)!r} given, numbers expected") from None
            if value.shape != size or not np.all(np.isfinite(value)):
                expected = "one finite number" if not size else f"{size[0]} finite numbers"
                raise ParameterError(f"payload.{name}", f"{getattr(self, name)!r} given, {expected} expected")
            object.__setattr__(self, name, float(value) if not size else tuple(map(float, value)))
        if max(map(abs, self.com)) > LENGTH:
            raise ParameterError("payload.com", f"{list(self.com)} given, coordinates of at most {LENGTH:g} m expected")
        problem = inertia_problem(self.mass, self.inertia_matrix)
        if problem:
            raise ParameterError("payload", problem)
        if self.mass == 0.0 and any(self.inertia):
            raise ParameterError("payload", "it has a rotational inertia but no mass; give its mass in kg")

    @property
    def inertia_matrix(self) -> Array:
        """Inertia about the centre, shape (3, 3), kg·m²."""
        xx, xy, xz, yy, yz, zz = self.inertia
        return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def as_payload(value: float | str | Payload | Mapping[str, Any] | None) -> Payload | None:
    """Read a payload as a user writes it.

    Args:
        value: A mass in kg (a point mass at the frame of the last moving link), a text ``MASS@LINK`` (at that link's
            frame), a `Payload`, or a mapping with its fields.

    Returns:
        The payload, None for none.

    Raises:
        ParameterError: A wrong key, size or sign.
    """
    if value is None or isinstance(value, Payload):
        return value
    if isinstance(value, Mapping):
        for key in value:
            if key not in _FIELDS:
                raise ParameterError(f"payload.{key}", f"unknown; a payload has {', '.join(_FIELDS)}")
        if "mass" not in value:
            raise ParameterError("payload.mass", "missing; give the payload's mass in kg")
        return Payload(**value)
    if isinstance(value, str) and "@" in value:
        mass, _, link = value.partition("@")
        return Payload(mass=_mass(mass), link=link.strip() or None)
    return Payload(mass=value)  # type: ignore[arg-type]  # any other text is refused there


def _mass(text: str) -> float:
    try:
        return as_number(text)
    except ValueError:
        raise ParameterError("payload.mass", f"'{text}' given, a number expected, kg: 2@tool0") from None
