"""What a log takes from the last body leaves a body that can be, and the estimates are the best that do."""

from __future__ import annotations

import dataclasses
import tempfile
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import minimize

import asmc_pin
from asmc_pin import JointLog, identify
from asmc_pin.identification.filtered_motion import filter_log
from asmc_pin.identification.possible_body import LastBody, pseudo_inertia
from asmc_pin.identification.torque_model import PAYLOAD, TorqueModel, point_mass, torque_model
from asmc_pin.identification.weighted_fit import Fit, fit

STEP, LENGTH = 0.004, 8.0
COULOMB, VISCOUS = np.array([0.3, 0.1]), np.array([0.2, 0.1])
TOO_FAR = np.array([-0.15, 0.05, -0.35])  # kg·m
FREE = ("coulomb:joint_1", "coulomb:joint_2", "viscous:joint_1", "viscous:joint_2", *PAYLOAD)


URDF = """<robot name="arm">
<link name="base"/>
<link name="upper"><inertial><origin xyz="0 0 0.15"/><mass value="3"/>
<inertia ixx="0.03" ixy="0" ixz="0" iyy="0.03" iyz="0" izz="0.01"/></inertial></link>
<link name="fore"><inertial><origin xyz="0.05 0.02 0.2"/><mass value="2"/>
<inertia ixx="0.02" ixy="0" ixz="0" iyy="0.025" iyz="0" izz="0.012"/></inertial></link>
<joint name="joint_1" type="revolute"><parent link="base"/><child link="upper"/><axis xyz="0 1 0"/>
<limit lower="-3" upper="3" effort="90" velocity="9"/></joint>
<joint name="joint_2" type="revolute"><parent link="upper"/><child link="fore"/><origin xyz="0 0 0.3"/>
<axis xyz="0.6 0.8 0"/><limit lower="-3" upper="3" effort="90" velocity="9"/></joint>
</robot>"""


@cache
def arm() -> asmc_pin.Arm:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "arm.urdf"
        path.write_text(URDF)
        return asmc_pin.load_arm(path)


def logged(mass: float, moment: np.ndarray, noise: float = 0.0, seed: int = 0) -> JointLog:
    """An exact motion, and the torque of the URDF with a point on its last link, of either sign."""
    t = np.arange(round(LENGTH / STEP)) * STEP
    rate = 2.0 * np.pi * np.array([[0.31, 0.83], [0.41, 0.97]])
    size = np.array([[0.8, 0.2], [0.9, 0.3]])
    angle = rate[:, :, None] * t
    q, v, a = (
        np.einsum("jk,jkt->tj", size * rate**order, wave)
        for order, wave in ((0, np.sin(angle)), (1, np.cos(angle)), (2, -np.sin(angle)))
    )
    links = arm().regressor(q, v, v, a)
    torque = links @ arm().inertial_parameters + links[..., 10:20] @ point_mass(mass, moment)[0]
    torque += COULOMB * np.sign(v) + VISCOUS * v
    torque += noise * np.random.default_rng(seed).normal(size=torque.shape)
    return JointLog("made", arm().joint_names, t, q, v, torque, "motor", ())


@cache
def body() -> LastBody:
    return LastBody.of(arm())


def model_of(log: JointLog) -> tuple[TorqueModel, np.ndarray]:
    model = torque_model(arm(), filter_log(log), np.full(2, 0.02))
    return model, np.array([name in FREE for name in model.names])


@cache
def too_much() -> Fit:
    """The log asks for a kilogram to be taken away where the body has none."""
    model, free = model_of(logged(-1.0, TOO_FAR, noise=0.1))
    return fit(model, model.usable, free)


def whole(found: Fit) -> np.ndarray:
    mass, *moment = (found.values[found.model.index(name)] for name in PAYLOAD)
    return body().own + pseudo_inertia(point_mass(mass, np.array(moment))[0])


def test_the_pseudo_inertia_of_two_points_is_the_sum_of_their_squares() -> None:
    places = np.array([[0.1, 0.2, -0.3, 1.0], [0.4, 0.0, 0.1, 1.0]])
    both = sum(point_mass(2.0, 2.0 * place[:3])[0] for place in places)
    np.testing.assert_allclose(pseudo_inertia(both), 2.0 * places.T @ places, atol=1e-15)


def test_a_log_that_takes_more_than_there_is_leaves_a_body_that_can_be() -> None:
    found = too_much()
    assert found.impossible is not None
    least = np.linalg.eigvalsh(body().own + pseudo_inertia(_taken(found)))[0]
    assert least < -0.01  # what the log alone asks for
    assert np.linalg.eigvalsh(whole(found))[0] > -1e-6
    assert np.linalg.eigvalsh(whole(found))[0] < 1e-4  # on the bound, and not somewhere inside


def _taken(found: Fit) -> np.ndarray:
    assert found.impossible is not None
    mass, *moment = (found.impossible[found.model.index(name)] for name in PAYLOAD)
    return point_mass(mass, np.array(moment))[0]


def test_what_is_found_on_the_bound_is_the_constrained_optimum_of_another_solver() -> None:
    found = too_much()
    model, places = found.model, np.flatnonzero(found.free)

    def at(x: np.ndarray) -> np.ndarray:
        values = found.values.copy()
        values[places] = x
        return values

    def cost(x: np.ndarray) -> float:
        return float(np.sum((model.residual(at(x))[0] / found.sigma)[found.rows] ** 2))

    def slope(x: np.ndarray) -> np.ndarray:
        residual, jacobian = model.residual(at(x))
        weighted = np.where(found.rows, residual / found.sigma**2, 0.0)
        return 2.0 * np.einsum("tj,tjp->p", weighted, jacobian[:, :, places])

    def least(x: np.ndarray) -> float:
        mass, *moment = (at(x)[model.index(name)] for name in PAYLOAD)
        return float(np.linalg.eigvalsh(body().own + pseudo_inertia(point_mass(mass, np.array(moment))[0]))[0])

    names = [model.names[i] for i in places]
    bounds = [(None, -1e-3) if name == "payload.mass" else (None, None) for name in names]
    start = np.array([{"payload.mass": -0.3 * body().mass}.get(name, 0.0) for name in names])
    other = minimize(
        cost,
        start,
        jac=slope,
        bounds=bounds,
        method="SLSQP",
        options={"maxiter": 200, "ftol": 1e-10},
        constraints=[{"type": "ineq", "fun": least}],
    )
    assert least(other.x) > -1e-6
    ours = found.values[places]
    assert cost(ours) <= other.fun * (1.0 + 1e-3)
    assert cost(ours) >= other.fun * (1.0 - 1e-3)
    np.testing.assert_allclose(ours, other.x, atol=2e-2 * body().mass)


def test_a_payload_that_can_be_is_found_without_the_bound() -> None:
    for share in (0.6, -0.5):
        model, free = model_of(logged(share * body().mass, share * body().own[:3, 3]))
        found = fit(model, model.usable, free)
        assert found.impossible is None
        assert found.values[model.index("payload.mass")] == pytest.approx(share * body().mass, rel=0.02)


def test_moments_alone_are_held_to_what_a_body_can_have() -> None:
    model, free = model_of(logged(0.0, np.zeros(3)))
    far = dataclasses.replace(model, rigid=model.rigid + model.carried @ np.array([0, 0, 0, 3.0, 0, 0, 0, 0, 0, 0]))
    free[model.index("payload.mass")] = False
    turned = dataclasses.replace(far, motion=model.motion, rigid=2.0 * model.rigid - far.rigid)
    found = fit(turned, turned.usable, free)
    assert found.impossible is not None
    assert np.linalg.eigvalsh(whole(found))[0] > -1e-6


def test_on_the_bound_it_is_said_and_no_interval_reaches_beyond_what_there_is() -> None:
    log = logged(-1.0, TOO_FAR, noise=0.1)
    found = identify(arm(), log, fix=("stribeck", "torque_constant", "delay"))
    assert not found.suspicions
    assert found.to_json_dict()["on_bound"] is True
    mass = found.parameters["payload.mass"]
    assert -body().mass <= mass.low <= mass.value <= mass.high
    assert any("cannot give away" in line for line in found.remarks())


@pytest.mark.long
def test_where_nearly_all_of_a_body_is_missing_the_interval_of_its_mass_still_holds_the_truth() -> None:
    truth, held, active = -0.99 * body().mass, [], 0
    for seed in range(15):
        model, free = model_of(logged(truth, -0.99 * body().own[:3, 3], noise=3.0, seed=seed))
        found = fit(model, model.usable, free)
        place = model.index("payload.mass")
        half = 2.0 * found.deviation[place]
        held.append(abs(found.values[place] - truth) <= half)
        active += found.impossible is not None
    assert active >= 3
    assert np.mean(held) >= 0.8
