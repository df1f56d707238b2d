"""Recorded robot data: read whole, checked, and turned into the error that M̄ would have made."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from condition_cases import chain

from asmc_pin import load_arm, verify
from asmc_pin.arms import Arm
from asmc_pin.condition.domain.recorded_motion import Recording, read_recording, tde_error
from asmc_pin.errors import ParameterError


@pytest.fixture(scope="module")
def two_link() -> Arm:
    return load_arm("two_link")


def swing(arm: Arm, dt: float = 1e-3, steps: int = 400) -> tuple[Recording, np.ndarray]:
    """An exact log of a smooth motion under the torque of inverse dynamics, and its acceleration."""
    t = np.arange(steps) * dt
    w = 2.0 + np.arange(arm.nv)
    q, v, a = (
        f[:, None] if f.ndim == 1 else f
        for f in (0.5 * np.sin(np.outer(t, w)), 0.5 * w * np.cos(np.outer(t, w)), -0.5 * w**2 * np.sin(np.outer(t, w)))
    )
    friction = arm.friction * np.sign(v) + arm.damping * v
    torque = np.einsum("tij,tj->ti", arm.mass_matrix(q), a) + arm.bias(q, v) + friction
    return Recording("log", t, q, v, torque), a


def test_tde_error_is_the_change_of_acceleration_less_that_of_torque_over_mbar(two_link: Arm) -> None:
    log, a = swing(two_link)
    mbar = np.array([0.05, 0.02])
    assert log.torque is not None
    expected = np.diff(a, axis=0) - np.diff(log.torque, axis=0) / mbar
    error = tde_error(two_link, mbar, log)
    assert np.isnan(error[0]).all()
    np.testing.assert_allclose(error[1:], expected, rtol=1e-8, atol=1e-9)
    twice = tde_error(two_link, mbar, log, period=2e-3)
    np.testing.assert_allclose(twice[2:], error[2:] + error[1:-1], rtol=1e-8, atol=1e-9)


def test_torque_step_on_constant_inertia_leaves_the_difference_of_the_inverse_inertias(tmp_path: Path) -> None:
    # N = (1/m − 1/m̄) Δτ on one joint of constant inertia at rest without gravity: none at all for m̄ = m.
    arm = chain(tmp_path, 1, 1).replace(gravity=(0.0, 0.0, 0.0))
    m = float(arm.mass_matrix(np.zeros(1))[0, 0])
    torque = np.array([0.0, 0.0, 0.3, 0.3])[:, None]
    log = Recording("step", np.arange(4) * 1e-3, np.zeros((4, 1)), np.zeros((4, 1)), torque)
    error = tde_error(arm, 0.4 * m, log)[1:, 0]
    np.testing.assert_allclose(error, [0.0, 0.3 * (1 / m - 1 / (0.4 * m)), 0.0], atol=1e-12)
    np.testing.assert_allclose(tde_error(arm, m, log)[1:], 0.0, atol=1e-12)


def test_velocities_that_were_not_logged_are_differences(two_link: Arm) -> None:
    log, _ = swing(two_link)
    without = Recording("log", log.time, log.q, None, log.torque)
    inside = slice(3, -2)
    np.testing.assert_allclose(
        tde_error(two_link, 0.03, without)[inside], tde_error(two_link, 0.03, log)[inside], rtol=1e-3, atol=1e-3
    )


def write(path: Path, header: str, rows: np.ndarray) -> Path:
    np.savetxt(path, rows, delimiter=",", header=header, comments="")
    return path


def test_verify_along_a_file_gives_norm_and_tde_error(two_link: Arm, tmp_path: Path) -> None:
    log, _ = swing(two_link)
    rows = np.column_stack((log.time, log.q, log.v, log.torque))
    numbered = write(tmp_path / "a.csv", "t,q1,q2,v1,v2,tau1,tau2", rows)
    named = write(
        tmp_path / "b.csv",
        "time, tau_joint_2, tau_joint_1, q_joint_1, q_joint_2, v_joint_1, v_joint_2, motor temperature",
        np.column_stack((rows[:, 0], rows[:, 6], rows[:, 5], rows[:, 1:5], rows[:, 0])),
    )
    first, second = (verify(two_link, 0.02, along=read_recording(path, two_link)) for path in (numbered, named))
    assert first.lower == second.lower
    assert first.tde_error is not None
    assert second.tde_error is not None
    np.testing.assert_allclose(first.tde_error, second.tde_error)
    np.testing.assert_allclose(first.tde_error, tde_error(two_link, 0.02, log), rtol=1e-6, atol=1e-9)
    only_q = read_recording(write(tmp_path / "c.csv", "t,q1,q2", rows[:, :3]), two_link)
    assert verify(two_link, 0.02, along=only_q).tde_error is None


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("t,q1\n0,0\n1,1\n", "no column 'q2' or 'q_joint_2'"),
        ("q1,q2\n0,0\n1,1\n", "no column 't' or 'time'"),
        ("t,a,b\n0,0,0\n1,1,1\n", "lacks joint columns"),
        ("t,q1,q2\n0,0,0\n", "1 rows"),
        ("t,q1,q2\n0,0,0\n0,1,1\n", "line 3: the time does not increase"),
        ("t,q1,q2\n0,0,0\n1,1,abc\n", "line 3, column 'q2'.*'abc'"),
        ("t,q1,q2\n0,0,0\n1,nan,1\n", "line 3, column 'q1'"),
        ("t,q1,q_joint_1,q2\n0,0,0,0\n1,1,1,1\n", "both 'q1' and 'q_joint_1'"),
        ("", "cannot be read"),
    ],
)
def test_a_malformed_file_is_named_with_its_line(two_link: Arm, tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "log.csv"
    path.write_text(text)
    with pytest.raises(ParameterError, match=message):
        read_recording(path, two_link)


def test_a_missing_file_unequal_spacing_and_odd_periods_are_refused(two_link: Arm, tmp_path: Path) -> None:
    with pytest.raises(ParameterError, match="cannot be read"):
        read_recording(tmp_path / "none.csv", two_link)
    log, _ = swing(two_link, steps=10)
    with pytest.raises(ParameterError, match="multiple of the recording"):
        tde_error(two_link, 0.02, log, period=1.5e-3)
    with pytest.raises(ParameterError, match="no torque"):
        tde_error(two_link, 0.02, Recording("log", log.time, log.q))
    with pytest.raises(ParameterError, match="resample"):
        tde_error(two_link, 0.02, Recording("log", log.time**2, log.q, log.v, log.torque))
