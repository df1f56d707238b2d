"""Identities of rigid-body physics, on every named arm and on random trees."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
import yourdfpy
from arm_urdf import trees, write
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from asmc_pin._typing import Array
from asmc_pin.arms import Arm, arm_names, load_arm
from asmc_pin.rigid_body.mass_matrix import mass_matrices

NAMES = arm_names()
RANDOM = settings(
    max_examples=60, deadline=None, derandomize=True, suppress_health_check=[HealthCheck.function_scoped_fixture]
)


@pytest.fixture(params=NAMES)
def arm(request: pytest.FixtureRequest) -> Arm:
    return load_arm(request.param, armature=0.03)


def states(arm: Arm, count: int = 8) -> tuple[Array, Array, Array]:
    generator = np.random.default_rng(7)
    return tuple(generator.uniform(-2.0, 2.0, (3, count, arm.nv)))  # type: ignore[return-value]


def times(matrix: Array, vector: Array) -> Array:
    return np.einsum("...ij,...j->...i", matrix, vector)


def joint_scale(mass: Array) -> Array:
    """sqrt(M_ii M_jj): an error relative to it does not hide behind the heaviest joint."""
    root = np.sqrt(np.diagonal(mass, axis1=-2, axis2=-1))
    return root[..., :, None] * root[..., None, :]


def assert_kernel_is_pinocchio(arm: Arm) -> None:
    q, *_ = states(arm)
    bare = arm.model.copy()
    bare.armature = np.zeros(arm.nv)
    data = bare.createData()
    expected = np.array([pin.crba(bare, data, x) for x in q]).reshape(-1, arm.nv, arm.nv) + np.diag(arm.armature)
    assert np.max(np.abs(mass_matrices(arm.tree, q) - expected) / joint_scale(expected)) < 1e-12
    assert np.max(np.abs(arm.mass_matrix(q) - expected) / joint_scale(expected)) < 1e-12


def assert_forward_undoes_inverse(arm: Arm) -> None:
    q, v, acceleration = states(arm)
    mass = arm.mass_matrix(q)
    torque = times(mass, acceleration) + arm.bias(q, v)
    # Judged in torque, so that a light wrist is not asked for more digits than its inertia has.
    excess = times(mass, arm.forward_dynamics(q, v, torque) - acceleration)
    assert np.max(np.abs(excess)) < 1e-11 * max(1.0, np.max(np.abs(torque)))


def assert_skew(arm: Arm) -> None:
    q, v, _ = states(arm)
    h = 1e-3

    def slope(step: float) -> Array:
        return (arm.mass_matrix(q + step * v) - arm.mass_matrix(q - step * v)) / (2.0 * step)

    rate = (4.0 * slope(h / 2.0) - slope(h)) / 3.0
    skew = rate - 2.0 * arm.coriolis(q, v)
    scale = max(1.0, np.max(np.abs(rate)))
    assert np.max(np.abs(skew + np.swapaxes(skew, -1, -2))) < 1e-8 * scale


def assert_bias_adds_up(arm: Arm) -> None:
    q, v, _ = states(arm)
    bias = arm.bias(q, v)
    assert times(arm.coriolis(q, v), v) + arm.gravity(q) == pytest.approx(
        bias, abs=1e-12 * max(1.0, np.abs(bias).max())
    )


def test_kernel_equals_pinocchio(arm: Arm) -> None:
    assert_kernel_is_pinocchio(arm)


def test_forward_dynamics_undoes_inverse_dynamics(arm: Arm) -> None:
    assert_forward_undoes_inverse(arm)


def test_mass_rate_minus_twice_coriolis_is_skew(arm: Arm) -> None:
    assert_skew(arm)


def test_bias_is_coriolis_plus_gravity(arm: Arm) -> None:
    assert_bias_adds_up(arm)


def test_mass_matrix_is_symmetric_positive_definite(arm: Arm) -> None:
    mass = arm.mass_matrix(states(arm)[0])
    assert np.array_equal(mass, np.swapaxes(mass, -1, -2))
    assert np.linalg.eigvalsh(mass).min() > 0.0


def test_coriolis_torque_is_quadratic_in_velocity(arm: Arm) -> None:
    q, v, _ = states(arm)
    once, thrice = times(arm.coriolis(q, v), v), times(arm.coriolis(q, 3.0 * v), 3.0 * v)
    assert thrice == pytest.approx(9.0 * once, abs=1e-11 * max(1.0, np.abs(thrice).max()))


@RANDOM
@given(text=trees())
def test_identities_hold_on_random_trees(text: str, tmp_path: Path) -> None:
    arm = load_arm(write(tmp_path, text), armature=0.02, payload={"mass": 0.7, "com": (0.1, 0, 0.2), "link": "link0"})
    assert_kernel_is_pinocchio(arm)
    assert_forward_undoes_inverse(arm)
    assert_skew(arm)
    assert_bias_adds_up(arm)


def urdf_reading(arm: Arm) -> yourdfpy.URDF:
    return yourdfpy.URDF.load(str(arm.source), load_meshes=False)


def urdf_poses(arm: Arm, reading: yourdfpy.URDF, q: Array) -> Array:
    """Link poses by yourdfpy, which knows nothing of Pinocchio, locked joints at their locks."""
    values = dict(zip(arm.joint_names, q, strict=True)) | dict(arm.locked)
    reading.update_cfg({name: value for name, value in values.items() if name in reading.actuated_joint_names})
    return np.array([reading.get_transform(link, reading.base_link) for link in arm.link_names])


@pytest.mark.parametrize("name", NAMES)
def test_links_stand_where_yourdfpy_puts_them(name: str) -> None:
    arm = load_arm(name)
    reading = urdf_reading(arm)
    assert set(arm.link_names) == set(reading.link_map)
    q, *_ = states(arm, 3)
    expected = np.array([urdf_poses(arm, reading, x) for x in q])
    assert arm.link_poses(q) == pytest.approx(expected, abs=1e-9)


def kinetic_energies(arm: Arm, q: Array, v: Array) -> Iterator[float]:
    """½ m c˙² + ½ ω·I ω of every link of the URDF, its motion by central differences of yourdfpy's poses."""
    reading, h = urdf_reading(arm), 1e-5
    before, here, after = (urdf_poses(arm, reading, q + step * v) for step in (-h, 0.0, h))
    for k, name in enumerate(arm.link_names):
        inertial = reading.link_map[name].inertial
        if inertial is None:
            continue
        frame = np.eye(4) if inertial.origin is None else inertial.origin
        velocity = (after[k] @ frame - before[k] @ frame)[:3] / (2.0 * h)
        turn = here[k, :3, :3] @ frame[:3, :3]
        spin = velocity[:, :3] @ turn.T
        omega = turn.T @ np.array([spin[2, 1], spin[0, 2], spin[1, 0]])
        yield 0.5 * inertial.mass * velocity[:, 3] @ velocity[:, 3] + 0.5 * omega @ inertial.inertia @ omega


@pytest.mark.parametrize("name", NAMES)
def test_kinetic_energy_is_that_of_the_urdfs_links(name: str) -> None:
    arm = load_arm(name, armature=0.0)
    q, v, _ = (x[0] for x in states(arm))
    assert 0.5 * v @ arm.mass_matrix(q) @ v == pytest.approx(sum(kinetic_energies(arm, q, v)), rel=1e-6)


@pytest.mark.parametrize("name", NAMES)
def test_gravity_torque_is_the_gradient_of_potential_energy(name: str) -> None:
    arm = load_arm(name, gravity=(1.0, -2.0, -9.0))
    reading, (q, *_), h = urdf_reading(arm), states(arm, 1), 1e-5

    def potential(q: Array) -> float:
        energy = 0.0
        for pose, link in zip(urdf_poses(arm, reading, q), arm.link_names, strict=True):
            inertial = reading.link_map[link].inertial
            if inertial is not None:
                frame = np.eye(4) if inertial.origin is None else inertial.origin
                energy -= inertial.mass * arm.gravity_vector @ (pose @ frame)[:3, 3]
        return energy

    slope = [(potential(q[0] + h * e) - potential(q[0] - h * e)) / (2.0 * h) for e in np.eye(arm.nv)]
    assert arm.gravity(q)[0] == pytest.approx(slope, abs=1e-7)


@settings(max_examples=20, deadline=None, derandomize=True)
@given(name=st.sampled_from(NAMES), mass=st.floats(0.0, 10.0), armature=st.floats(0.0, 2.0))
def test_mass_matrix_is_affine_in_payload_and_armature(name: str, mass: float, armature: float) -> None:
    load = {"com": (0.02, -0.05, 0.1)}
    light, heavy = load_arm(name, payload={"mass": 0.0, **load}), load_arm(name, payload={"mass": 10.0, **load})
    q, *_ = states(light)
    share = mass / 10.0
    expected = (1.0 - share) * light.mass_matrix(q) + share * heavy.mass_matrix(q)
    expected += np.diag(armature - light.armature)
    between = light.replace(payload={"mass": mass, **load}, armature=armature).mass_matrix(q)
    assert np.max(np.abs(between - expected) / joint_scale(expected)) < 1e-12
