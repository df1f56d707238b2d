"""Tracking errors predicted by the linear map: against exact oracles, against rollouts."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from asmc_pin._typing import Array
from asmc_pin.arms import Arm, load_arm
from asmc_pin.controllers import CONTROLLERS
from asmc_pin.engine import Rollout, rollout
from asmc_pin.errors import ParameterError
from asmc_pin.plant import Drive, Friction, Plant, Sensor
from asmc_pin.references import Multisine
from asmc_pin.sampled import (
    SampledLoop,
    closed_loop,
    drift_error,
    predict_tracking,
    reversal_estimate,
    stability,
    step_response,
)
from asmc_pin.sampled.gain_choice.gains import suggest_gains
from asmc_pin.sampled.gain_warnings import gain_warnings
from asmc_pin.words.remedy_texts import MBAR_REMEDY

MASS = np.array([[0.7, 0.2, 0.05], [0.2, 0.3, 0.04], [0.05, 0.04, 0.09]])
MBAR = np.array([0.15, 0.1, 0.04])
UR5_MBAR = 0.5 * np.array([0.1483264, 0.1674553, 0.1504278, 0.0810652, 0.0933441, 0.0171369])
UR5_MOTION = Multisine(
    offset=[0.0, -1.2, 1.0, -0.5, 0.3, 0.0],
    amplitude=[0.6, 0.4, 0.5, 0.5, 0.4, 0.6],
    frequency=[0.3, 0.4, 0.5, 0.35, 0.45, 0.6],
    rise=1.0,
)
JOINT = """<robot name="turntable"><link name="base"/><link name="table"><inertial>
<mass value="2"/><inertia ixx="0.8" iyy="0.8" izz="0.8" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="turn" type="continuous"><parent link="base"/><child link="table"/><axis xyz="0 0 1"/></joint></robot>"""


def run_ppc(arm: Arm, loop: SampledLoop, motion: Multisine, seconds: float, friction: Friction) -> Rollout:
    law = CONTROLLERS["ppc"](
        mbar=loop.mbar, ks=loop.ks, beta=float(loop.beta[0]), period=loop.period,
        acceleration=loop.acceleration, filter_hz=loop.filter_hz, pairing=loop.pairing,
    )  # fmt: skip
    return rollout(Plant(arm, friction=friction, effort_limit=np.full(arm.nv, np.inf)), law, motion, seconds)


def rms(error: Array) -> Array:
    return np.sqrt(np.mean(error**2, axis=0))


@pytest.mark.parametrize(
    "timing",
    [
        {},
        {"acceleration": "position"},
        {"filter_hz": 60.0},
        {"delay": 1.0},
        {"acceleration": "position", "delay": 2.0},
        {"acceleration": "position", "pairing": "last"},
        {"velocity": "difference", "reading_delay": 1.3},
    ],
    ids=str,
)
def test_drifting_load_leaves_the_error_of_the_formula_whatever_the_inertia(timing: dict) -> None:
    loop, drift = SampledLoop(MBAR, [10.0, 12.0, 15.0], 11.0, 0.001, **timing), np.array([3.0, -2.0, 1.0])
    system = closed_loop(MASS, loop)
    state = np.zeros(system.matrix.shape[0])
    for k in range(6000):
        state = system.matrix @ state + system.load @ (drift * loop.period * k)
    np.testing.assert_allclose(-state[system.blocks["q"]], drift_error(loop, drift), rtol=1e-9)


def test_a_friction_reversal_is_a_blow_of_l_2f_over_mbar_where_the_estimate_is_fast() -> None:
    # M̄ = 0.9·M, so a = 0.9: the estimate settles within two ticks, slow poles at 8 and 14 1/s.
    mass = np.diag([0.5, 0.2])
    loop, coulomb = SampledLoop([0.45, 0.18], 8.0, 14.0, 0.001), np.array([5.0, 2.0])
    response, (peak, energy) = step_response(mass, loop, 2.0 * coulomb), reversal_estimate(loop, coulomb)
    np.testing.assert_allclose(np.diag(response.peak), peak, rtol=0.02)
    np.testing.assert_allclose(np.diag(response.energy), energy, rtol=0.04)
    np.testing.assert_allclose(response.rms(3.0), np.sqrt(3.0 * energy), rtol=0.02)


def test_estimate_of_a_reversal_is_continuous_where_beta_equals_ks() -> None:
    equal, near = (reversal_estimate(SampledLoop(0.4, 9.0, 9.0 * x, 0.001), [2.0]) for x in (1.0, 1.0 + 2e-6))
    np.testing.assert_allclose(equal, near, rtol=1e-5)
    assert equal[0] == pytest.approx(0.001 * 4.0 / 0.4 / (9.0 * math.e))


def test_a_step_on_an_unstable_loop_has_no_finite_error() -> None:
    loop = SampledLoop(MBAR, 300.0, 300.0, 0.01)
    assert np.isinf(step_response(MASS, loop, np.ones(3)).peak).all()


@pytest.mark.parametrize("delay", [0.0, 0.4, 1.0, 2.7])
def test_map_with_the_plant_s_substeps_is_the_rollout_to_rounding(tmp_path: Path, delay: float) -> None:
    path = tmp_path / "turntable.urdf"
    path.write_text(JOINT)
    arm = load_arm(path)
    loop = SampledLoop(0.2, 9.0, 14.0, 0.002, acceleration="position", filter_hz=40.0, delay=delay)
    hold = Multisine(offset=[0.0], amplitude=[0.0], frequency=[1.0])
    law = CONTROLLERS["ppc"](mbar=0.2, ks=9.0, beta=14.0, period=0.002, acceleration="position", filter_hz=40.0)
    plant = Plant(arm, substeps=3, friction=Friction(0.0, 0.7), drive=Drive(delay=delay))
    run = rollout(plant, law, hold, 0.4, q0=[0.1], v0=[-0.5])
    system = closed_loop(arm.mass_matrix(np.zeros(1)), loop, viscous=0.7, substeps=3)
    state = np.zeros(system.matrix.shape[0])
    state[system.blocks["q"]], state[system.blocks["v"]], state[system.blocks["slope"]] = 0.1, -0.5, -0.5
    for k in range(run.time.size):
        assert state[system.blocks["q"]][0] == pytest.approx(run.q[0, k, 0], abs=1e-13)
        assert state[system.blocks["v"]][0] == pytest.approx(run.v[0, k, 0], abs=1e-12)
        state = system.matrix @ state


@pytest.mark.parametrize("timing", [{}, {"acceleration": "position", "filter_hz": 100.0, "pairing": "last"}], ids=str)
def test_tracking_error_of_the_ur5_is_predicted_to_1_percent(timing: dict) -> None:
    arm, loop = load_arm("ur5"), SampledLoop(UR5_MBAR, 12.0, 12.0, 0.001, **timing)
    run = run_ppc(arm, loop, UR5_MOTION, 4.0, Friction(0.0, 0.0))
    predicted = predict_tracking(arm, loop, UR5_MOTION, 4.0)
    actual = run.q_ref - run.q[0]
    np.testing.assert_allclose(predicted.rms, rms(actual), rtol=0.015)
    assert (rms(predicted.error - actual) < 0.03 * rms(actual)).all()


def test_tracking_error_with_differenced_velocities_is_predicted_to_2_percent_and_is_half_as_large_again() -> None:
    # What the linear prediction leaves out, velocity forces of the error, grows with the square of the error.
    arm = load_arm("ur5")
    measured, differenced = (SampledLoop(UR5_MBAR, 12.0, 12.0, 0.001, velocity=v) for v in ("measured", "difference"))
    sensor = Sensor(velocity="difference")
    law = CONTROLLERS["ppc"](mbar=UR5_MBAR, ks=12.0, beta=12.0, period=0.001, pairing="mean")
    plant = Plant(arm, friction=Friction(0.0, 0.0), effort_limit=np.full(arm.nv, np.inf), sensor=sensor)
    run = rollout(plant, law, UR5_MOTION, 4.0)
    predicted = predict_tracking(arm, differenced, UR5_MOTION, 4.0)
    np.testing.assert_allclose(predicted.rms, rms(run.q_ref - run.q[0]), rtol=0.02)
    # Joints 1 to 4; the wrist's own inertia asks for torque that runs ahead of the estimate.
    ratio = predicted.rms / predict_tracking(arm, measured, UR5_MOTION, 4.0).rms
    np.testing.assert_allclose(ratio[:4], 1.5, rtol=0.1)


def test_tracking_error_under_friction_that_reverses_is_predicted_to_5_percent() -> None:
    arm, loop = load_arm("ur5"), SampledLoop(UR5_MBAR, 12.0, 12.0, 0.001)
    coulomb, viscous = [8.0, 8.0, 5.0, 2.0, 2.0, 1.0], [1.0, 1.0, 1.0, 0.2, 0.2, 0.1]
    run = run_ppc(arm, loop, UR5_MOTION, 6.0, Friction(coulomb, viscous))
    predicted = predict_tracking(arm, loop, UR5_MOTION, 6.0, coulomb=coulomb, viscous=viscous)
    actual = run.q_ref - run.q[0]
    np.testing.assert_allclose(predicted.rms, rms(actual), rtol=0.05)
    np.testing.assert_allclose(predicted.peak, np.abs(actual).max(axis=0), rtol=0.05)


def test_a_prediction_needs_a_reference_for_the_same_joints() -> None:
    arm, loop = load_arm("two_link"), SampledLoop([0.01, 0.01], 9.0, 9.0, 0.001)
    with pytest.raises(ParameterError, match="reference: has 6 joints, the loop 2, the arm 2"):
        predict_tracking(arm, loop, UR5_MOTION, 1.0)


def test_drift_that_a_design_promises_bounds_a_slow_motion_and_is_no_wild_guess() -> None:
    arm = load_arm("two_link")
    slow = Multisine(offset=[0.0, 0.0], amplitude=[1.5, 0.5], frequency=0.05, rise=2.0)
    speed = 2.0 * math.pi * 0.05 * np.array([1.5, 0.5])
    design = suggest_gains(arm, 0.01, 0.001, speed=speed, samples=256)
    run = run_ppc(arm, design.loop, slow, 20.0, Friction(0.0, 0.0))
    largest = np.abs(run.q_ref - run.q[0])[3000:].max(axis=0)
    assert (largest < 1.02 * design.expected.drift).all()
    assert (largest > 0.5 * design.expected.drift).all()


def test_reversal_that_a_design_promises_is_that_of_a_rollout(tmp_path: Path) -> None:
    path = tmp_path / "turntable.urdf"
    path.write_text(JOINT)
    arm = load_arm(path)
    design = suggest_gains(arm, 0.4, 0.002, coulomb=3.0, samples=16)
    # A triangle-like swing would be ideal; a sine of 1 Hz passes its reversal fast enough.
    swing = Multisine(offset=[0.0], amplitude=[1.0], frequency=[1.0], phase=[0.5 * math.pi])
    with_friction = run_ppc(arm, design.loop, swing, 3.0, Friction(3.0, 0.0))
    without = run_ppc(arm, design.loop, swing, 3.0, Friction(0.0, 0.0))
    after = slice(700, None)  # the first reversal at speed is at t = 0.5 s; the start is another matter
    difference = np.abs(with_friction.q - without.q)[0, after, 0].max()
    assert difference == pytest.approx(float(design.expected.reversal_peak[0]), rel=0.1)


def laws(**changes: object) -> dict[str, object]:
    shared = {"mbar": UR5_MBAR, "ks": 10.0, "beta": 10.0, "period": 0.001} | changes
    return {
        "PPC": CONTROLLERS["ppc"](**shared),
        "Proposed": CONTROLLERS["baek2016"](**shared, phi=10.0, alpha=1.0, epsilon=0.1),
        "BSMC": CONTROLLERS["bsmc"](**shared, gain=1.0, boundary=0.5),
    }


def test_sound_gains_draw_no_warning() -> None:
    assert gain_warnings(load_arm("ur5"), laws()) == []


def test_unstable_gains_draw_one_warning_for_all_laws_that_share_them() -> None:
    warnings = gain_warnings(load_arm("ur5"), laws(ks=80.0, beta=80.0) | {"Other": object()})
    assert len(warnings) == 2
    assert warnings[0].startswith("PPC, Proposed, BSMC: the sampled loop is unstable at q = (")
    assert "times these β and K_s" in warnings[0]
    assert warnings[1].startswith("BSMC: inside its boundary layer")


@pytest.mark.long
def test_a_steep_boundary_layer_a_delay_and_gravity_each_draw_their_own_warning() -> None:
    arm = load_arm("ur5")
    steep = CONTROLLERS["bsmc"](mbar=UR5_MBAR, ks=10.0, beta=10.0, period=0.001, gain=100.0, boundary=0.02)
    (warning,) = gain_warnings(arm, {"BSMC": steep})
    assert "β acts as β + K/Φ = (5.01e+03" in warning
    assert "unstable" in gain_warnings(arm, {"PPC": laws()["PPC"]}, delay=8.0)[0]
    printed = CONTROLLERS["ppc"](mbar=0.01, ks=1.0, beta=1.0, period=0.001)
    (warning,) = gain_warnings(load_arm("two_link"), {"PPC": printed})
    assert "gravity drives the sampled loop away" in warning


def test_friction_that_only_some_trials_have_is_not_counted_on() -> None:
    arm, stiff = load_arm("ur5"), {"PPC": laws(ks=80.0, beta=80.0)["PPC"]}
    without = gain_warnings(arm, stiff)
    assert gain_warnings(arm, stiff, viscous=np.array([[40.0] * 6, [0.0] * 6])) == without
    assert gain_warnings(arm, stiff, viscous=np.array([[40.0] * 6, [30.0] * 6])) != without


def test_mbar_beyond_twice_the_inertia_has_no_gains_to_fall_back_to() -> None:
    (warning,) = gain_warnings(load_arm("ur5"), {"PPC": laws(mbar=4.0 * UR5_MBAR)["PPC"]})
    assert (
        f"no β and K_s in this proportion were found stable with this M̄: {MBAR_REMEDY}; with these β and K_s" in warning
    )


@pytest.mark.parametrize(
    ("source", "mbar", "gain"), [("two_link", 0.01, 1.0), ("two_link", 0.01, 30.0), ("two_link", 0.1, 10.0)]
)
def test_what_a_comparison_advises_is_what_stability_finds(source: str, mbar: float, gain: float) -> None:
    arm = load_arm(source)
    law = CONTROLLERS["ppc"](mbar=mbar, ks=gain, beta=gain, period=0.001)
    (warning,) = gain_warnings(arm, {"PPC": law})
    report = stability(arm, mbar, gain, gain, 0.001)
    assert report.remedy
    assert warning.endswith(f"; {report.remedy}")
    assert f"remedy: {report.remedy}" in report.lines()
