"""What compiled code knows of a plant: its numbers as rows with a column for each joint, and its scalars."""

from __future__ import annotations

from typing import NamedTuple

# Rows of the plant's parameters, (rows, nv) for each trial; names and units as in `Friction`, `EndStops` and `Drive`.
(
    LIMIT,
    VISCOUS,
    FORWARD,
    BACKWARD,
    BREAK_FORWARD,
    BREAK_BACKWARD,
    SCALE,
    BRISTLE,
    BRISTLE_DAMPING,
    STOP_LOWER,
    STOP_UPPER,
    STOP_STIFFNESS,
    STOP_DAMPING,
    REMAINING,
    MEAN_REMAINING,
    CORNER,
    NO_LOAD,
    SPEED_LIMIT,
    COUNT,
) = range(19)
PLANT_ROWS = 19

# Rows of a trial's state: angles, velocities, mean torque of the last period as the drives report it, mean torque of
# friction and of disturbances in it, and how far presliding joints have given way.
Q, V, TORQUE, FRICTION, EXTERNAL, BEND = range(6)
STATE_ROWS = 6

# Rows of scratch.
(
    AT_Q,
    AT_V,
    NEXT_Q,
    NEXT_V,
    MIDDLE,
    EARLY,
    PUSH,
    FORCE,
    BIAS,
    AHEAD,
    BACK,
    SHIFT,
    RHS,
    X,
    IMPULSE,
    OTHER_IMPULSE,
    DRAG,
    RATE,
    CORRECTION,
    PRESENT,
    SUM_Q,
    SUM_V,
    TOTAL,
    BEGAN_Q,
    BEGAN_V,
    LOW,
    HIGH,
) = range(27)
SCRATCH_ROWS = 27

# Square matrices of scratch: M, factors, and two more.
MASS, FACTOR, MATRIX, LOCAL = range(4)
SQUARES = 4

SEMI_IMPLICIT, MIDPOINT, RK4 = range(3)
SCHEMES = {"semi_implicit": SEMI_IMPLICIT, "midpoint": MIDPOINT, "rk4": RK4}
"""The integrators by their names, as compiled code knows them."""


class Setup(NamedTuple):
    """The scalars of a plant, and of its log.

    Attributes:
        period: L, s.
        step: Length of an integration step, s.
        substeps: Steps per period.
        scheme: One of `SCHEMES`.
        friction: Whether any joint has friction.
        constant: Whether its levels are the same at all velocities, and in both directions.
        yields: Whether joints give way before they break loose.
        stops: Whether there are end stops.
        shaped: Whether the torque can differ from the command after its limit.
        foldback: Part of a speed limit over which it takes the torque away.
        senses: Whether the law is told anything but the truth.
        exact_velocity: Whether its velocity is the true one, with noise, and not made of readings.
        keep: Weight of a new difference in that velocity.
        delay_fraction: Of the age of a reading, periods, what is beyond whole ones.
        speed_bound: rad/s.
        error_bound: rad.
        log_every: One tick in how many is logged.
    """

    period: float
    step: float
    substeps: int
    scheme: int
    friction: bool
    constant: bool
    yields: bool
    stops: bool
    shaped: bool
    foldback: float
    senses: bool
    exact_velocity: bool
    keep: float
    delay_fraction: float
    speed_bound: float
    error_bound: float
    log_every: int
