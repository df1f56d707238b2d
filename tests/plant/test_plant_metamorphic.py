"""What may not matter: how joints are called, where link frames lie, what else runs in the batch, where it runs."""

from __future__ import annotations

from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from xml.etree import ElementTree

import numpy as np
import pytest
from plant_cases import Waving
from scipy.spatial.transform import Rotation

from asmc_pin.arms import load_arm
from asmc_pin.controllers import Baek2016
from asmc_pin.engine import rollout
from asmc_pin.plant import Disturbance, Drive, EndStops, Friction, Plant, Sensor, Spread

Q = {"ur5": np.array([0.3, -1.0, 1.2, 0.4, 0.8, 0.2]), "two_link": np.array([-1.2, 0.4])}


def full_plant(arm, link=None):
    """Everything at once."""
    push = {"profile": "pulse", "force": [3.0, -2.0, 5.0], "start": 0.05, "duration": 0.08}
    return Plant(
        arm,
        friction=Friction(1.0, 0.2, breakaway=1.4, stribeck_velocity=0.05),
        drive=Drive(delay=0.6, current_hz=300.0, velocity_limit=3.0, gear=50.0, rotor_inertia=1e-5),
        sensor=Sensor(resolution=1e-7, position_noise=1e-7, velocity="filter"),
        end_stops=EndStops(stiffness=1e3),
        disturbances=[
            Disturbance(profile="noise", torque=0.5, frequency=10.0),
            *([] if link is None else [Disturbance(link=link, **push)]),
        ],
        seed=11,
    )


def run(plant, q, trials=(0,), duration=0.15):
    law = Baek2016(mbar=0.1, ks=8.0, beta=8.0, period=1e-3, phi=50.0, alpha=0.5, epsilon=0.05)
    return rollout(plant, law, Waving(q), duration, batch=len(trials), trials=trials)


def rewritten(arm, change, folder):
    """The arm from its own URDF, changed."""
    root = ElementTree.fromstring(arm.urdf_text)
    change(root)
    path = folder / "changed.urdf"
    ElementTree.ElementTree(root).write(path)
    return load_arm(path)


def new_name(name):
    return f"z{sum(map(ord, name))}_{name[::-1]}"


@pytest.mark.parametrize("name", Q)
def test_the_names_of_joints_and_links_change_no_bit(name, tmp_path):
    plain = load_arm(name)
    plain = rewritten(plain, lambda root: None, tmp_path)

    def rename(root):
        for element in root.iter():
            for key in ("name", "link"):
                if element.get(key) is not None and element.tag in ("joint", "link", "parent", "child"):
                    element.set(key, new_name(element.get(key)))

    renamed = rewritten(plain, rename, tmp_path)
    assert not set(plain.joint_names) & set(renamed.joint_names)
    tool = plain.link_names[-1]
    one = run(full_plant(plain, tool), Q[name])
    other = run(full_plant(renamed, new_name(tool)), Q[name])
    for field in ("q", "v", "torque", "friction_torque", "q_measured", "external_torque", "gain"):
        np.testing.assert_array_equal(getattr(one, field), getattr(other, field), err_msg=field)


def _origin(element):
    made = np.eye(4)
    if element is not None:
        made[:3, 3] = [float(x) for x in element.get("xyz", "0 0 0").split()]
        made[:3, :3] = Rotation.from_euler("xyz", [float(x) for x in element.get("rpy", "0 0 0").split()]).as_matrix()
    return made


def _set_origin(parent, pose):
    element = parent.find("origin")
    if element is None:
        element = ElementTree.SubElement(parent, "origin")
    element.set("xyz", " ".join(repr(float(x)) for x in pose[:3, 3]))
    element.set("rpy", " ".join(repr(float(x)) for x in Rotation.from_matrix(pose[:3, :3]).as_euler("xyz")))


def _move_frames(root, rng, kept):
    """Give every link another frame: turned anyhow, shifted along its joint's axis, or anyhow behind a fixed one."""
    moved = {}
    for joint in root.findall("joint"):
        child = joint.find("child").get("link")
        frame = np.eye(4)
        if child != kept:
            frame[:3, :3] = Rotation.random(random_state=rng).as_matrix()
            if joint.get("type") == "fixed":
                frame[:3, 3] = rng.normal(0.0, 0.2, 3)
            else:
                axis = np.array([float(x) for x in joint.find("axis").get("xyz").split()])
                frame[:3, 3] = rng.normal(0.0, 0.2) * axis
                new = frame[:3, :3].T @ axis
                joint.find("axis").set("xyz", " ".join(repr(float(x)) for x in new))
        moved[child] = frame
    for joint in root.findall("joint"):
        parent, child = joint.find("parent").get("link"), joint.find("child").get("link")
        before = np.linalg.inv(moved.get(parent, np.eye(4)))
        _set_origin(joint, before @ _origin(joint.find("origin")) @ moved[child])
    for link in root.findall("link"):
        inertial = link.find("inertial")
        if inertial is not None:
            _set_origin(
                inertial, np.linalg.inv(moved.get(link.get("name"), np.eye(4))) @ _origin(inertial.find("origin"))
            )


@pytest.mark.parametrize("name", Q)
def test_where_the_frames_of_links_lie_changes_rounding_only(name, tmp_path):
    arm = rewritten(load_arm(name), lambda root: None, tmp_path)
    tool = arm.link_names[-1]
    moved = rewritten(arm, lambda root: _move_frames(root, np.random.default_rng(2), tool), tmp_path)
    assert np.abs(moved.tree.translation - arm.tree.translation).max() > 0.01
    one, other = (run(full_plant(each, tool), Q[name], duration=0.1) for each in (arm, moved))
    # Readings are rounded to 1e-7 rad, where a rounding error may tip a count over, and the law differentiates them.
    np.testing.assert_allclose(one.q, other.q, rtol=0, atol=1e-6)
    np.testing.assert_allclose(one.external_torque, other.external_torque, rtol=0, atol=1e-5)
    free = [rollout(Plant(each, friction=Friction(1.0, 0.2)), LAW, Waving(Q[name]), 0.1) for each in (arm, moved)]
    np.testing.assert_allclose(free[0].q, free[1].q, rtol=0, atol=1e-10)


LAW = Baek2016(mbar=0.1, ks=8.0, beta=8.0, period=1e-3, phi=50.0, alpha=0.5, epsilon=0.05)


def scattered():
    plant = full_plant(load_arm("two_link"))
    return Plant(
        plant.arm,
        friction=plant.friction,
        sensor=plant.sensor,
        disturbances=plant.disturbances,
        spread=Spread(mass=0.1, com=0.01, inertia=0.1, friction=0.2),
        seed=3,
    )


def in_another_process(trials):
    result = run(scattered(), Q["two_link"], trials)
    return result.q, result.torque, result.friction_torque, result.q_measured


def test_splitting_a_batch_among_processes_changes_no_bit():
    together = in_another_process(range(6))
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
        parts = list(pool.map(in_another_process, [[0, 4], [1, 2, 3], [5]]))
    for trials, part in zip(([0, 4], [1, 2, 3], [5]), parts, strict=True):
        for whole, split in zip(together, part, strict=True):
            np.testing.assert_array_equal(whole[trials], split)
