"""Named and shipped arms: what they are, and that they are what their source says."""

from __future__ import annotations

import copy
import pickle
import re
import sys
import tomllib
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import mujoco
import numpy as np
import pytest
from arm_urdf import LIMIT, inertial, joint, link, robot, two_joints, write
from paths import DOCS

import asmc_pin.arms
from asmc_pin.arms import ARMS, Arm, arm_names, arms_table, load_arm
from asmc_pin.errors import ArmError, ParameterError

PROMISED = "two_link rv4fd ur3 ur5 ur10 panda kinova xarm7 z1 so100 so101 double_pendulum two_dofs"
JOINTS = {
    "panda": 7,
    "xarm7": 7,
    "so100": 5,
    "so101": 5,
    "double_pendulum": 2,
    "two_dofs": 2,
    "two_link": 2,
    "rv4fd": 2,
}


@pytest.mark.parametrize("name", PROMISED.split())
def test_named_arm_loads_with_its_driven_joints_only(name: str) -> None:
    arm = load_arm(name)
    assert arm.name == name
    assert arm.nv == arm.model.nq == arm.model.nv == JOINTS.get(name, 6)


def test_registry_holds_exactly_the_promised_arms() -> None:
    assert sorted(arm_names()) == sorted(PROMISED.split())


@pytest.mark.parametrize("name", ["two_link", "rv4fd"])
def test_shipped_arm_says_where_it_comes_from(name: str) -> None:
    entry = ARMS[name]
    source = tomllib.loads((entry.path().parent / "SOURCE.toml").read_text(encoding="utf-8"))
    assert source["published"]
    assert source["assumed"]
    assert source["licence"] == "BSD-2-Clause"


def test_table_has_a_row_per_arm() -> None:
    rows = {row["name"]: row for row in arms_table()}
    assert list(rows) == arm_names()
    assert rows["kinova"]["kinds"] == "3 continuous, 3 revolute"
    assert rows["double_pendulum"]["effort limits"] == "not declared"
    assert rows["z1"]["licence"] == "MPL-2.0"


# The two-link arm of Section III, from the equations of the paper.
L1, L2, M1, M2, G = 0.2, 0.1, 10.0, 5.0, 9.81


def closed_form(q: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    c1, c2, s2, c12 = np.cos(q[0]), np.cos(q[1]), np.sin(q[1]), np.cos(q[0] + q[1])
    m12 = L2**2 * M2 + L1 * L2 * M2 * c2
    mass = np.array([[L2**2 * M2 + 2 * L1 * L2 * M2 * c2 + L1**2 * (M1 + M2), m12], [m12, L2**2 * M2]])
    h = M2 * L1 * L2 * s2
    coriolis = np.array([-h * v[1] ** 2 - 2 * h * v[0] * v[1], h * v[0] ** 2])
    gravity = np.array([M2 * L2 * G * c12 + (M1 + M2) * L1 * G * c1, M2 * L2 * G * c12])
    return mass, coriolis, gravity


def test_two_link_equals_the_papers_closed_form() -> None:
    arm = load_arm("two_link")
    for q, v in np.random.default_rng(3).uniform(-4.0, 4.0, (200, 2, 2)):
        mass, coriolis, gravity = closed_form(q, v)
        assert np.max(np.abs(arm.mass_matrix(q) - mass)) < 1e-12
        assert np.max(np.abs(arm.coriolis(q, v) @ v - coriolis)) < 1e-12
        assert np.max(np.abs(arm.gravity(q) - gravity)) < 1e-12


def test_two_link_rises_towards_plus_z_and_carries_the_papers_friction() -> None:
    arm = load_arm("two_link")
    tip = arm.link_names.index("tip")
    assert arm.link_poses(np.zeros(2))[tip, :3, 3] == pytest.approx([0.3, 0.0, 0.0], abs=1e-15)
    assert arm.link_poses(np.array([np.pi / 2, 0.0]))[tip, :3, 3] == pytest.approx([0.0, 0.0, 0.3], abs=1e-15)
    assert arm.friction.tolist() == [50.0, 50.0]
    assert arm.damping.tolist() == [0.0, 0.0]


def test_rv4fd_carries_its_motors_and_the_torque_read_from_the_paper() -> None:
    arm = load_arm("rv4fd")
    assert arm.armature == pytest.approx(0.375e-4 * 80**2 * np.ones(2))
    assert arm.effort_limit.tolist() == [360.0, 360.0]
    # Fig. 12 shows torques of 0 to 75 N·m: holding the arm out must fit in, with room for friction.
    assert 0.0 < arm.gravity(np.zeros(2))[1] < arm.gravity(np.zeros(2))[0] < 75.0 - arm.friction[0]


def test_papers_mbar_satisfies_lemma_1_on_rv4fd_thanks_to_its_motors() -> None:
    arm, mbar = load_arm("rv4fd"), np.diag([0.07, 0.12])
    q = np.stack([np.zeros(50), np.radians(np.linspace(0.0, 80.0, 50))], axis=-1)

    def worst(arm: Arm) -> float:
        return float(np.linalg.norm(np.eye(2) - np.linalg.solve(arm.mass_matrix(q), mbar), ord=2, axis=(-2, -1)).max())

    assert worst(arm) < 1.0 < worst(arm.replace(armature=0.0))


@pytest.mark.parametrize("name", ["two_link", "rv4fd"])
def test_mujoco_loads_the_shipped_arm_and_agrees(name: str) -> None:
    arm = load_arm(name)
    model = mujoco.MjModel.from_xml_path(str(arm.source))
    model.dof_armature[:] = arm.armature
    model.dof_frictionloss[:], model.dof_damping[:], model.opt.timestep = 0.0, 0.0, 1e-9
    model.jnt_limited[:] = 0
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:], data.qfrc_applied[:] = [0.3, -0.8], [1.0, 2.0], [5.0, -3.0]
    mujoco.mj_forward(model, data)
    ours = arm.forward_dynamics(np.array([0.3, -0.8]), np.array([1.0, 2.0]), np.array([5.0, -3.0]))
    assert ours == pytest.approx(data.qacc, rel=1e-8)


def test_pinocchios_aba_sees_the_armature_and_neither_friction_nor_damping(tmp_path: Path) -> None:
    rough = joint("shoulder", "base", "upper", extra=LIMIT + '<dynamics friction="7" damping="3"/>')
    smooth, arm = (load_arm(write(tmp_path, two_joints(first=text), f"{k}.urdf")) for k, text in enumerate(("", rough)))
    assert arm.friction.tolist() == [7.0, 0.0]
    assert arm.damping.tolist() == [3.0, 0.0]
    q, v, torque = np.array([[0.3, -0.2], [1.0, 2.0], [4.0, 5.0]])
    assert np.array_equal(arm.forward_dynamics(q, v, torque), smooth.forward_dynamics(q, v, torque))
    heavy = arm.replace(armature=[0.4, 0.1])
    expected = np.linalg.solve(arm.mass_matrix(q) + np.diag([0.4, 0.1]), torque - arm.bias(q, v))
    assert heavy.forward_dynamics(q, v, torque) == pytest.approx(expected, rel=1e-12)


def test_continuous_joint_has_one_angle_and_periodic_dynamics() -> None:
    arm = load_arm("kinova")
    assert arm.continuous.tolist() == [True, False, False, True, False, True]
    assert np.all(np.isinf(arm.lower[arm.continuous]))
    lower, upper = arm.box
    assert lower[arm.continuous] == pytest.approx(-np.pi * np.ones(3))
    assert upper[1] == 5.46288055874
    q = np.linspace(-1.0, 1.0, 6)
    turned = q + 2.0 * np.pi * arm.continuous
    assert arm.mass_matrix(turned) == pytest.approx(arm.mass_matrix(q), abs=1e-12)
    assert arm.gravity(turned) == pytest.approx(arm.gravity(q), abs=1e-12)


def test_leading_axes_are_kept_and_broadcast() -> None:
    arm = load_arm("ur5")
    q, v = np.random.default_rng(0).uniform(-1.0, 1.0, (2, 3, 4, 6))
    assert arm.mass_matrix(q).shape == (3, 4, 6, 6)
    assert arm.link_poses(q[0]).shape == (4, len(arm.link_names), 4, 4)
    assert arm.gravity(q[0, 0]).shape == (6,)
    assert arm.mass_matrix(np.empty((0, 6))).shape == (0, 6, 6)
    both = arm.forward_dynamics(q, v[0], np.zeros(6))
    assert np.array_equal(both[2, 1], arm.forward_dynamics(q[2, 1], v[0, 1], np.zeros(6)))


def test_arm_of_one_joint_keeps_its_axes(tmp_path: Path) -> None:
    arm = load_arm(write(tmp_path, robot(link("base"), link("slug", inertial(2.0)), joint("spin", "base", "slug"))))
    assert arm.mass_matrix(np.zeros((5, 1))).shape == (5, 1, 1)
    assert arm.coriolis(np.zeros(1), np.ones(1)).shape == (1, 1)
    assert arm.forward_dynamics(np.zeros(1), np.zeros(1), np.ones(1)) == pytest.approx([1.0 / (0.015 + 2.0 * 0.01)])


@pytest.mark.parametrize("bad", [np.zeros(5), np.zeros((6, 1)), 3.0, "abc"])
def test_wrong_number_of_angles_is_said_plainly(bad: object) -> None:
    with pytest.raises(ParameterError, match=r"q: .*(given|numbers expected)") as caught:
        load_arm("ur5").mass_matrix(bad)  # type: ignore[arg-type]
    assert caught.value.parameter == "q"


def test_arm_cannot_be_changed() -> None:
    arm = load_arm("ur5")
    for array in (
        arm.lower,
        arm.effort_limit,
        arm.friction,
        arm.armature,
        arm.gravity_vector,
        *(part for part in vars(arm.tree).values() if part is not arm.tree.coupling),
        *vars(arm.tree.coupling).values(),
    ):
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 0
    with pytest.raises(AttributeError):
        arm.name = "other"  # type: ignore[misc]
    with pytest.raises(TypeError):
        arm.locked["elbow_joint"] = 0.0  # type: ignore[index]


def test_arm_travels_between_processes_with_its_options() -> None:
    arm = load_arm("z1", payload=1.5, armature=0.1, lock={"joint6": 0.3}, gravity=(0.0, 0.0, 9.81))
    q = np.linspace(0.1, 0.5, 5)
    for twin in (pickle.loads(pickle.dumps(arm)), copy.deepcopy(arm)):
        assert np.array_equal(twin.mass_matrix(q), arm.mass_matrix(q))
        assert np.array_equal(twin.gravity(q), arm.gravity(q))
        assert twin.payload == arm.payload


def test_arm_serves_several_threads_at_once() -> None:
    arm = load_arm("panda")
    q = np.random.default_rng(5).uniform(-1.0, 1.0, (40, 20, 7))
    expected, interval = arm.link_poses(q), sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    try:
        with ThreadPoolExecutor(4) as pool:
            assert np.array_equal(list(pool.map(arm.link_poses, q)), expected)
    finally:
        sys.setswitchinterval(interval)


def test_path_gives_the_arm_without_its_meshes_and_says_what_was_read(tmp_path: Path) -> None:
    visual = '<visual><geometry><mesh filename="package://nowhere/link.dae"/></geometry></visual>'
    text = two_joints().replace('<link name="base">', f'<link name="base">{visual}')
    path = write(tmp_path, text, "mine.urdf")
    for source in (path, str(path)):
        arm = load_arm(source)
        assert (arm.name, arm.source, arm.urdf_text) == ("mine", path, text)
        assert len(arm.sha256) == 64
        assert arm.files.folder == tmp_path.resolve()


def test_meshes_of_a_named_arm_can_be_found() -> None:
    arm = load_arm("ur5")
    mesh = arm.urdf_text.split("package://")[1].split('"')[0]
    assert arm.files.mesh(f"package://{mesh}").is_file()


def test_code_in_the_docs_runs_and_does_what_it_says() -> None:
    page = (DOCS / "arms.md").read_text(encoding="utf-8")
    names = {"asmc_pin": asmc_pin.arms, "load_arm": load_arm, "q": np.zeros((4, 6))}
    for block in re.findall(r"```python\n(.*?)```", page, re.DOTALL):
        exec(block, names)
    bare = load_arm("panda", payload=2.0, lock={"panda_joint3": 0.0})
    added = np.broadcast_to(np.diag([0.3, 0.3, 0.3, 0.1, 0.1, 0.1]), (4, 6, 6))
    np.testing.assert_allclose(names["M"] - bare.mass_matrix(names["q"]), added, atol=1e-12)
    upright = bare.gravity(names["q"])
    np.testing.assert_allclose(names["arm"].gravity(names["q"]), -9.81 / np.linalg.norm(bare.gravity_vector) * upright)


def test_name_of_an_arm_wins_over_a_file_and_a_path_does_not(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write(tmp_path, two_joints(), "ur5")
    monkeypatch.chdir(tmp_path)
    assert load_arm("ur5").nv == 6
    assert load_arm("./ur5").nv == load_arm(Path("ur5")).nv == 2


@pytest.mark.parametrize(
    ("source", "message"),
    [
        ("ur50", "'ur5'"),
        ("Panda", "did you mean 'panda'"),
        ("zzz", "two_link"),
        ("nowhere/arm.urdf", "no such file"),
        ("arm.urdf", "no such file"),
    ],
)
def test_unknown_arm_lists_the_nearest(source: str, message: str) -> None:
    with pytest.raises(ArmError, match=message) as caught:
        load_arm(source)
    assert caught.value.source == source
