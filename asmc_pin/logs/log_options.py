"""What the reader of a log is told: names of columns, units, and what the logged torque is."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from asmc_pin.errors import ParameterError

QUANTITIES = ("t", "q", "v", "tau")
"""Time, angles, velocities and torques, by the names that options use."""

TIME_UNITS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}

SIDES = ("motor", "link")


@dataclass(frozen=True, kw_only=True)
class LogOptions:
    """How a log is to be read; what is omitted is guessed where it can be, and said.

    Attributes:
        columns: ``t``, ``q``, ``v``, ``tau`` to a column's name, or to a pattern with ``{n}`` (the joint's number from
            1), ``{i}`` (from 0) or ``{joint}`` (its name) in it; ``-`` for a quantity that is not to be read.
        degrees: Whether angles and velocities of turning joints are in degrees and degrees/s.
        time_unit: Unit of the time stamps, ``"s"``, ``"ms"``, ``"us"`` or ``"ns"``.
        motor_constant: N·m at the joint for each unit that is logged, one value or one per joint; for currents in A.
        torque_side: ``"motor"``: the torque before rotor and friction, of a current for example; ``"link"``: of a
            sensor after the gear, which does not feel the rotor.
        topic: Of a bag; may be omitted where only one has `sensor_msgs/JointState`.

    Raises:
        ParameterError: One of them is none of these.
    """

    columns: Mapping[str, str] = field(default_factory=dict)
    degrees: bool = False
    time_unit: str = "s"
    motor_constant: Sequence[float] | float | None = None
    torque_side: str = "motor"
    topic: str | None = None

    def __post_init__(self) -> None:
        """Say what is none of the words."""
        for name, value, known in (
            ("time_unit", self.time_unit, tuple(TIME_UNITS)),
            ("torque_side", self.torque_side, SIDES),
            *(("columns", key, QUANTITIES) for key in self.columns),
        ):
            if value not in known:
                raise ParameterError(name, f"'{value}' given; expected one of {', '.join(known)}")
