"""Noise of torque and error by the linear map: exact sums, simulated runs, and what is told before a run."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import solve_discrete_lyapunov

from asmc_pin._typing import Array
from asmc_pin.arms import Arm, load_arm
from asmc_pin.cli import main
from asmc_pin.controllers import CONTROLLERS, Setpoint
from asmc_pin.engine import rollout
from asmc_pin.experiment import Experiment
from asmc_pin.plant import Friction, Plant, Sensor, moving_arms
from asmc_pin.sampled import SampledLoop, closed_loop, stability
from asmc_pin.sampled.frozen_arms import gravity_stiffness
from asmc_pin.sampled.noise.noise_response import noise_rms, rounding_bound
from asmc_pin.sampled.noise.noise_warnings import BUDGET, noise_warnings
from asmc_pin.sampled.noise.sensor_model import LoopSensor, loop_sensor
from asmc_pin.sampled.noise.sensor_noise import count_torque
from asmc_pin.sampled.workspace_worst import workspace_of
from asmc_pin.study.notes.comparison_notes import before_the_run
from asmc_pin.study.plant_sensor import sensor_of_plant

MASS = np.array([[0.7, 0.2, 0.05], [0.2, 0.3, 0.04], [0.05, 0.04, 0.09]])
MBAR = np.array([0.15, 0.1, 0.04])
UR5 = load_arm("ur5", armature=[0.5, 0.5, 0.3, 0.05, 0.05, 0.05])
UR5_MBAR = [0.623, 0.877, 0.649, 0.262, 0.208, 0.0198]
UR5_START = np.array([0.0, -1.3, 1.6, -1.2, -1.4, 0.0])
SENSORS = [
    {"encoder_bits": 17},
    {"encoder_bits": [17, 20, 14], "velocity": "measured"},
    {"velocity_noise": 1e-3},
    {"torque_noise": 0.1, "velocity": "difference", "velocity_filter_hz": 60.0},
    {"encoder_bits": 17, "velocity": "measured", "velocity_noise": 1e-4, "torque_noise": 0.02},
]
TIMINGS = [{}, {"acceleration": "position", "delay": 1.4}, {"filter_hz": 35.0}]


@pytest.mark.parametrize("sensor", SENSORS, ids=str)
@pytest.mark.parametrize("timing", TIMINGS, ids=str)
def test_variances_are_the_sum_of_squared_impulse_responses_and_solve_the_lyapunov_equation(
    timing: dict, sensor: dict
) -> None:
    seen = loop_sensor(3, **sensor)
    loop = SampledLoop(MBAR, [12.0, 20.0, 31.0], 25.0, 0.002, **timing, **seen.timing)
    torque, error = noise_rms(MASS, loop, seen)
    system = closed_loop(MASS, loop, sensed=True)
    sizes = {"angle": seen.count / math.sqrt(12.0), "rate": seen.rate_noise, "report": seen.torque_noise / MBAR}
    entered = np.hstack([system.sensed[name] * size for name, size in sizes.items()])
    state, u, q = entered, np.zeros(3), np.zeros(3)
    for _ in range(4000):
        u += ((system.drive @ state) ** 2).sum(axis=1)
        q += (state[system.blocks["q"]] ** 2).sum(axis=1)
        state = system.matrix @ state
    np.testing.assert_allclose(torque, MBAR * np.sqrt(u), rtol=1e-6)
    np.testing.assert_allclose(error, np.sqrt(q), rtol=1e-6)
    # The equation itself; scipy's solver needs states of one size to keep its digits.
    powers = {"q": 0, "angle": 0, "v": 1, "rate": 1, "slope": 1}
    unit = np.concatenate([np.full(3, loop.period ** powers.get(name.split("-")[0], 2)) for name in system.blocks])
    scaled = unit[:, None] * entered
    covariance = solve_discrete_lyapunov(unit[:, None] * system.matrix / unit, scaled @ scaled.T)
    np.testing.assert_allclose(error**2, np.diag(covariance)[system.blocks["q"]], rtol=1e-4)


def test_an_unstable_loop_has_no_stationary_noise() -> None:
    seen = loop_sensor(3, encoder_bits=17)
    loop = SampledLoop(MBAR, 300.0, 300.0, 0.01, **seen.timing)
    assert np.isinf(noise_rms(MASS, loop, seen)).all()


def test_the_bound_of_rounding_is_reached_by_the_worst_order_of_half_counts_and_by_no_other() -> None:
    seen = loop_sensor(3, encoder_bits=14)
    loop = SampledLoop(MBAR, 20.0, 25.0, 0.002, **seen.timing)
    torque, error = rounding_bound(MASS, loop, seen.count)
    system = closed_loop(MASS, loop, sensed=True)
    ticks, responses, state = 3000, [], system.sensed["angle"]
    for _ in range(ticks):
        responses.append(np.vstack([loop.mbar[:, None] * (system.drive @ state), state[system.blocks["q"]]]))
        state = system.matrix @ state
    response = np.array(responses)[::-1]
    rng = np.random.default_rng(0)
    for output, bound in enumerate([*torque, *error]):
        worst = 0.5 * seen.count * np.sign(response[:, output])
        assert np.sum(response[:, output] * worst) == pytest.approx(bound, rel=1e-6)
        other = 0.5 * seen.count * rng.uniform(-1.0, 1.0, worst.shape)
        assert abs(np.sum(response[:, output] * other)) < bound


def test_a_count_of_17_bits_at_4_khz_is_worth_672_newton_metres() -> None:
    seen = loop_sensor(1, encoder_bits=17)
    loop = SampledLoop(0.877, 8.0, 8.0, 0.00025, **seen.timing)
    assert count_torque(loop, seen.count) == pytest.approx([672.6], abs=0.1)
    # Behind a gear of 100 the motor's encoder is as much finer; and a measured v is not differenced twice.
    assert count_torque(loop, loop_sensor(1, encoder_bits=17, gear=100.0).count) == pytest.approx([6.726], abs=1e-3)
    assert count_torque(replace(loop, velocity="measured"), seen.count) == pytest.approx([0.00269], rel=1e-2)


@dataclass(frozen=True)
class Swinging:
    """Joints that move on at speeds that swing by half, and cross counts in every period; or that stand."""

    q: Array
    v: Array
    duration: float = math.inf

    @property
    def nv(self) -> int:
        return self.q.size

    def evaluate(self, t: Array) -> Setpoint:
        rate = 2.0 + 0.7 * np.arange(self.nv)
        phase = np.multiply.outer(t, rate)
        moved = self.v * (t[:, None] + 0.5 * (1.0 - np.cos(phase)) / rate)
        return Setpoint(self.q + moved, self.v * (1.0 + 0.5 * np.sin(phase)), 0.5 * self.v * rate * np.cos(phase))


def noise_of_a_run(
    arm: Arm, loop: SampledLoop, sensor: Sensor, motion: Swinging, seconds: float, settled: float
) -> tuple[Array, Array, Array]:
    """Torque and error of a run less those of the run with a perfect sensor of the same kind; and where it was."""
    law = CONTROLLERS["ppc"](
        mbar=loop.mbar, ks=loop.ks, beta=float(loop.beta[0]), period=loop.period, acceleration=loop.acceleration,
        filter_hz=loop.filter_hz, pairing="mean" if loop.averages_torque else "last",
    )  # fmt: skip
    free = {"friction": Friction(0.0, 0.0), "effort_limit": np.full(arm.nv, np.inf)}
    perfect = Sensor(velocity=sensor.velocity, filter_hz=sensor.filter_hz)
    noisy, clean = (
        rollout(Plant(arm, sensor=kind, **free), law, motion, seconds, q0=motion.q, v0=1.0 * motion.v)
        for kind in (sensor, perfect)
    )
    late = noisy.time > settled
    return noisy.torque[0, late] - clean.torque[0, late], clean.q[0, late] - noisy.q[0, late], clean.q[0, late]


def seen_by(sensor: Sensor) -> LoopSensor:
    return sensor_of_plant(Plant(UR5, sensor=sensor))


@pytest.mark.parametrize(
    ("sensor", "timing"),
    [
        (Sensor(bits=20), {}),
        (Sensor(bits=17), {"filter_hz": 50.0}),
        (Sensor(bits=17, velocity="filter", filter_hz=60.0), {}),
        (Sensor(bits=17, velocity="exact"), {"acceleration": "position"}),
        (Sensor(velocity="exact", velocity_noise=1e-4), {}),
        (Sensor(velocity="exact", torque_noise=0.1), {}),
        (Sensor(position_noise=2e-6), {"pairing": "last"}),
    ],
    ids=str,
)
def test_torque_noise_of_a_moving_ur5_is_predicted_to_15_percent(sensor: Sensor, timing: dict) -> None:
    seen = seen_by(sensor)
    loop = SampledLoop(UR5_MBAR, 12.0, 12.0, 0.001, **timing, **seen.timing)
    motion = Swinging(UR5_START, 0.3 * np.linspace(1.0, 1.31, 6) * (-1.0) ** np.arange(6))
    assert (np.abs(motion.v) * 0.5 * loop.period > seen.count).all(), "counts are crossed in every period"
    torque, _, q = noise_of_a_run(UR5, loop, sensor, motion, 3.0, 1.5)
    some = q[::100]
    predicted, _ = noise_rms(UR5.mass_matrix(some), loop, seen, stiffness=gravity_stiffness(UR5, some))
    expected = np.sqrt(np.mean(predicted**2, axis=0))
    np.testing.assert_allclose(np.sqrt(np.mean(torque**2, axis=0)), expected, rtol=0.15)


TURNTABLE = """<robot name="turntable"><link name="base"/><link name="table"><inertial>
<mass value="2"/><inertia ixx="0.8" iyy="0.8" izz="0.8" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="turn" type="continuous"><parent link="base"/><child link="table"/><axis xyz="0 0 1"/></joint></robot>"""


@pytest.mark.parametrize(
    ("sensor", "timing"),
    [
        (Sensor(bits=18), {}),
        (Sensor(bits=18), {"filter_hz": 80.0}),
        (Sensor(velocity="exact", velocity_noise=3e-4), {}),
        (Sensor(velocity="exact", torque_noise=0.01), {}),
    ],
    ids=str,
)
def test_error_noise_on_a_constant_inertia_is_predicted_to_15_percent(
    tmp_path: Path, sensor: Sensor, timing: dict
) -> None:
    # Errors forget slowly, at some 40 1/s here: 20 s are some hundreds of independent values.
    path = tmp_path / "turntable.urdf"
    path.write_text(TURNTABLE)
    arm = load_arm(path)
    seen = sensor_of_plant(Plant(arm, sensor=sensor))
    loop = SampledLoop(0.5, 40.0, 40.0, 0.001, **timing, **seen.timing)
    motion = Swinging(np.array([0.3]), np.array([0.4]))
    torque, error, _ = noise_of_a_run(arm, loop, sensor, motion, 20.0, 1.0)
    for found, predicted in zip((torque, error), noise_rms(arm.mass_matrix(motion.q), loop, seen), strict=True):
        assert np.sqrt(np.mean(found**2)) == pytest.approx(predicted.item(), rel=0.15)


@pytest.mark.parametrize("timing", [{}, {"filter_hz": 50.0}, {"pairing": "last"}], ids=str)
def test_at_rest_rounding_stays_below_its_bound_and_comes_within_a_factor_of_four(timing: dict) -> None:
    sensor = Sensor(bits=17)
    seen = seen_by(sensor)
    loop = SampledLoop(UR5_MBAR, 12.0, 12.0, 0.001, **timing, **seen.timing)
    still = Swinging(UR5_START + 1e-5, np.zeros(6))
    torque, error, _ = noise_of_a_run(UR5, loop, sensor, still, 3.0, 1.5)
    bounds = rounding_bound(UR5.mass_matrix(still.q), loop, seen.count, stiffness=gravity_stiffness(UR5, still.q))
    for found, bound in zip((torque, error), bounds, strict=True):
        assert (np.abs(found).max(axis=0) < bound).all()
    assert (np.abs(torque).max(axis=0) / bounds[0]).max() > 0.25, "the bound says something"


def test_stability_s_noise_is_the_worst_of_the_box_and_null_where_it_was_not_asked_for() -> None:
    seen = loop_sensor(6, encoder_bits=20)
    report = stability(UR5, UR5_MBAR, 8.0, 8.0, 0.001, sensor=seen, samples=256, limits=False)
    noise = report.noise
    assert noise is not None
    found = workspace_of(UR5, samples=300, seed=9, gravity=True)
    torque, error = noise_rms(found.mass, report.loop, seen, stiffness=found.stiffness)
    assert (torque.max(axis=0) < 1.001 * noise.torque_rms).all()
    assert (error.max(axis=0) < 1.001 * noise.error_rms).all()
    assert any("is worth m̄ Δq/L²" in line for line in report.lines())
    plain = stability(UR5, UR5_MBAR, 8.0, 8.0, 0.001, samples=64, limits=False).to_json_dict()
    told = report.to_json_dict()
    for key in ("torque_noise_rms", "error_noise_rms", "count_torque"):
        assert plain[key] is None
        assert len(told[key]) == 6
    assert (plain["velocity"], plain["pairing"], told["velocity"], told["pairing"]) == (
        "measured", "last", "difference", "mean",
    )  # fmt: skip


def test_the_command_line_takes_an_encoder_at_the_motor_and_says_what_does_not_go_together(
    capfd: pytest.CaptureFixture[str],
) -> None:
    def run(*options: str) -> tuple[object, str, str]:
        with pytest.raises(SystemExit) as end:
            main([*base, *options])
        return end.value.code, *capfd.readouterr()

    base = ["stability", "two_link", "--mbar", "0.02", "--ks", "12", "--beta", "12", "--period", "0.001"]
    motor = ["--encoder-bits", "15", "--encoder-side", "motor", "--gear", "100"]
    status, out, _ = run(*motor, "--json")
    told = json.loads(out)
    assert status == 0
    np.testing.assert_allclose(told["encoder_count"], 2.0 * math.pi / 2**15 / 100.0)
    np.testing.assert_allclose(told["count_torque"], 0.02 * 1e6 * np.array(told["encoder_count"]))
    for wrong, named in (
        (["--encoder-bits", "15", "--encoder-side", "motor"], "--gear"),
        (["--gear", "100"], "--encoder-bits"),
        (["--velocity", "difference", "--velocity-noise", "0.1"], "--velocity-noise"),
        (["--encoder-bits", "-3"], "--encoder-bits"),
        (["--velocity-filter-hz", "50"], "--velocity-filter-hz"),
    ):
        status, out, message = run(*wrong)
        assert (status, out) == (2, "")
        assert named in message


def at_4_khz(**sensor: object) -> Experiment:
    return Experiment.from_dict(
        {
            "name": "fast", "period": 0.00025, "duration": 1.0,
            "arm": {"source": "ur5", "armature": [0.5, 0.5, 0.3, 0.05, 0.05, 0.05]},
            "plant": {"drive": {"delay": 1.0}, "sensor": {"bits": 17, **sensor}},
            "reference": {"kind": "quintic", "start": [0.0, -1.3, 1.6, -1.2, -1.4, 0.0], "move": 0.8,
                          "targets": [0.2, -1.2, 1.5, -1.1, -1.3, 0.1]},
            "defaults": {"mbar": UR5_MBAR, "ks": 8.0, "beta": 8.0},
            "controllers": {"PPC": {"law": "ppc"}},
        }
    )  # fmt: skip


def test_what_a_count_is_worth_is_told_before_the_run_with_bits_filter_and_period_that_would_do() -> None:
    experiment = at_4_khz()
    plant = experiment.build_plant()
    moving = moving_arms(plant, experiment.period, experiment.duration)
    lines = before_the_run(experiment, plant, moving, experiment.build_controllers(), {})
    (told,) = [line for line in lines if "one count" in line]
    assert "m̄ Δq/L² = (477.8, 672.6," in told.replace("672.7", "672.6")
    assert "on drives of (150, 150, 150, 28, 28, 28) N·m" in told
    assert "7 bits more, or filter_hz = " in told
    assert ", or L = " in told


def test_the_bits_that_are_advised_are_enough_and_one_fewer_is_not() -> None:
    arm, limit = UR5, np.array([150.0] * 3 + [28.0] * 3)
    law = CONTROLLERS["ppc"](mbar=UR5_MBAR, ks=8.0, beta=8.0, period=0.00025, pairing="mean")

    def told(bits: int) -> str:
        seen = loop_sensor(6, encoder_bits=bits)
        (line,) = noise_warnings(arm, {"PPC": law}, seen, delay=1.0, effort_limit=limit)
        return line

    assert "7 bits more" in told(17)
    assert f"for {100.0 * BUDGET:g} % of" in told(23)
    assert f"for {100.0 * BUDGET:g} % of" not in told(24)


def test_a_perfect_sensor_draws_no_word_of_noise_and_one_without_limits_no_remedy() -> None:
    law = CONTROLLERS["ppc"](mbar=UR5_MBAR, ks=8.0, beta=8.0, period=0.001)
    limit = np.full(6, np.inf)
    assert noise_warnings(UR5, {"PPC": law}, loop_sensor(6, velocity="difference"), effort_limit=limit) == []
    (line,) = noise_warnings(UR5, {"PPC": law}, loop_sensor(6, encoder_bits=12), effort_limit=limit)
    assert "no limit" in line
    assert "bits more" not in line
