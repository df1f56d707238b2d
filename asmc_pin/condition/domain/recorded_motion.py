"""Recorded robot data: the norm along it, and the TDE error that M̄ would have made."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.condition.norm.two_conditions import check_mbar
from asmc_pin.disk.reading import user_path
from asmc_pin.errors import ParameterError
from asmc_pin.logs.log_table import numbers, read_table
from asmc_pin.words.text import printable

if TYPE_CHECKING:
    from asmc_pin.arms import Arm


@dataclass(frozen=True, eq=False)
class Recording:
    """What was logged while an arm moved.

    Attributes:
        name: Where it comes from.
        time: Shape (T,), s, increasing.
        q: Shape (T, nv), rad (m where prismatic).
        v: Joint velocities, shape (T, nv), rad/s; None where not logged.
        torque: Torque at the joints, after the gear, shape (T, nv), N·m; None where not logged.
        acceleration: Measured, within the band of `torque`, shape (T, nv), rad/s²; None where only a model has it.
    """

    name: str
    time: Array
    q: Array
    v: Array | None = None
    torque: Array | None = None
    acceleration: Array | None = None


def read_recording(path: str | Path, arm: Arm) -> Recording:
    """Read the log of an arm from a CSV file, also gzipped or with ``;``, or Parquet.

    The header names the columns: ``t`` or ``time`` in s; per joint ``q1`` … or ``q_<joint>`` in rad; and, as far as
    they were logged, ``v1`` … or ``v_<joint>`` in rad/s and ``tau1`` … or ``tau_<joint>`` in N·m. Others are ignored.

    Args:
        path: The file.
        arm: Whose joints they are, base first.

    Returns:
        The recording.

    Raises:
        ParameterError: It cannot be read, a column is missing, or a row is malformed; the message names the line.
    """
    path = user_path(path)
    table = read_table(path, _fail)
    columns = list(table.columns)
    clock = next((name for name in ("t", "time") if name in columns), None)
    if clock is None:
        given = printable(", ".join(columns))
        raise ParameterError("along", f"{path.name} has no column 't' or 'time'; its columns: {given}")
    time = numbers(path, table, [clock], _fail)[:, 0]
    if len(time) < 2:
        raise ParameterError("along", f"{path.name} has {len(time)} rows, at least 2 expected")
    late = np.flatnonzero(np.diff(time) <= 0.0)
    if late.size:
        raise ParameterError("along", f"{path.name}, line {late[0] + 3}: the time does not increase")
    q = _group(path, table, "q", arm.joint_names)
    if q is None:
        expected = ", ".join(f"q{i + 1}" for i in range(arm.nv))
        raise ParameterError(
            "along", f"{path.name} lacks joint columns; {expected} or q_<joint> expected, one per joint"
        )
    return Recording(
        path.name, time, q, _group(path, table, "v", arm.joint_names), _group(path, table, "tau", arm.joint_names)
    )


def tde_error(arm: Arm, mbar: Any, recording: Recording, *, period: float | None = None) -> Array:
    """The TDE error N = Γ − Γ̂ that M̄ would have made on recorded motion and torque.

    Γ of (3) is q̈ − M̄⁻¹τ, and Γ̂ is Γ one period before (6). Where the recording has accelerations, they are q̈, and no
    model is in it. Else q̈ is taken from the model, M⁻¹(τ − C q̇ − g − f), with the friction that the URDF declares, and
    none is differentiated out of the encoder: then it is not the error of the robot itself, as far as the model is
    wrong. It never is the error of a loop closed with this M̄, whose torque would have been another one.

    Args:
        arm: The arm.
        mbar: Diagonal of M̄, one value or nv of them, kg·m².
        recording: With torque, equally spaced in time; velocities are central differences of q where not logged.
        period: L, s; a multiple of the spacing; default one spacing.

    Returns:
        Shape (T, nv), rad/s² (m/s² where prismatic); NaN in the first period.

    Raises:
        ParameterError: No torque, unequal spacing, or a period that is no multiple of it.
    """
    values = check_mbar(mbar, arm.nv)
    if recording.torque is None:
        raise ParameterError("along", f"{recording.name} has no torque; add columns tau1 … in N·m")
    spacing = np.diff(recording.time)
    step = float(np.median(spacing))
    if np.any(np.abs(spacing - step) > 0.01 * step):
        raise ParameterError(
            "along",
            f"{recording.name}: its rows are {spacing.min():g} to {spacing.max():g} s apart; resample it, or have "
            "'asmc-pin identify ARM LOG --mbar' do it (asmc_pin.mbar_on_log)",
        )
    lag = 1 if period is None else round(period / step)
    if lag < 1 or (period is not None and abs(lag * step - period) > 0.01 * step):
        raise ParameterError("period", f"{period:g} s given, a multiple of the recording's {step:g} s expected")
    acceleration = recording.acceleration
    if acceleration is None:
        v = recording.v if recording.v is not None else np.gradient(recording.q, recording.time, axis=0)
        load = arm.bias(recording.q, v) + arm.friction * np.sign(v) + arm.damping * v
        acceleration = np.linalg.solve(arm.mass_matrix(recording.q), (recording.torque - load)[..., None])[..., 0]
    gamma = acceleration - recording.torque / values
    error = np.full_like(gamma, np.nan)
    error[lag:] = gamma[lag:] - gamma[:-lag]
    return error


def _fail(message: str) -> ParameterError:
    return ParameterError("along", message)


def _group(path: Path, table: Any, kind: str, joints: Sequence[str]) -> Array | None:
    """The columns of one quantity in the order of the joints; None where there is none of them."""
    found = []
    for i, joint in enumerate(joints):
        names = [name for name in (f"{kind}{i + 1}", f"{kind}_{joint}") if name in table.columns]
        if len(names) > 1:
            raise ParameterError("along", f"{path.name} has both '{names[0]}' and '{names[1]}'; keep one")
        found.append(names[0] if names else None)
    if all(name is None for name in found):
        return None
    if None in found:
        joint = joints[found.index(None)]
        raise ParameterError("along", f"{path.name} has no column '{kind}{found.index(None) + 1}' or '{kind}_{joint}'")
    return numbers(path, table, [str(name) for name in found], _fail)
