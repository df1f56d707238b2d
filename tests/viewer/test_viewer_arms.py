"""Arms as they are drawn: attached, moving as Pinocchio says, fine enough, and honest about what is missing."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from arm_urdf import write
from coupled_urdf import coupled_tree, gripper
from scipy.spatial import cKDTree
from viewer_cases import BENT, bent_arm

from asmc_pin.arms import arm_names, load_arm
from asmc_pin.arms.sources.robot_files import RobotFiles
from asmc_pin.viewer import PlayedMotion, describe, draw
from asmc_pin.viewer.drawing.drawn_bodies import assemble, attachments, body_poses, joint_frames
from asmc_pin.viewer.drawing.mesh_simplify import simplify
from asmc_pin.viewer.drawing.surface import Surface, join
from asmc_pin.viewer.drawing.visuals import read_visuals


def visual(geometry: str, rest: str = "") -> str:
    return f"<visual>{rest}<geometry>{geometry}</geometry></visual>"


def corners(surface: Surface) -> np.ndarray:
    return np.stack([surface.vertices.min(axis=0), surface.vertices.max(axis=0)])


def apart(surface: Surface) -> np.ndarray:
    """Vertices that differ by more than a millimetre: a tree of thousands of equal points is slow."""
    return np.unique(np.round(surface.vertices, 3), axis=0)


@pytest.mark.parametrize("name", arm_names())
def test_consecutive_links_are_drawn_attached(name: str) -> None:
    arm = load_arm(name)
    parts = assemble(arm)
    assert not parts.notes
    surfaces = [join(surfaces) for surfaces in parts.surfaces]
    for body, (parent, placement, _, _) in enumerate(parts.frames[1:], start=1):
        child = surfaces[body].moved(placement)
        low, high = corners(child)
        parent_low, parent_high = corners(surfaces[parent])
        # The widest gap that a maker left between two housings is the UR5's, 3 mm between base and shoulder.
        assert np.all(low <= parent_high + 0.004), arm.joint_names[body - 1]
        assert np.all(parent_low <= high + 0.004), arm.joint_names[body - 1]
        distance, _ = cKDTree(apart(surfaces[parent])).query(apart(child))
        assert distance.min() < 0.02, arm.joint_names[body - 1]


@pytest.mark.parametrize("name", arm_names())
def test_bodies_move_as_pinocchio_moves_the_links(name: str) -> None:
    arm = load_arm(name)
    q = np.random.default_rng(3).uniform(-2.0, 2.0, (4, arm.nv))
    poses, links = body_poses(joint_frames(arm), q), arm.link_poses(q)
    for link, (_, body, pose) in enumerate(attachments(arm)):
        np.testing.assert_allclose(poses[:, body] @ pose, links[:, link], atol=1e-9)


def test_mimicking_links_are_drawn_where_they_go(tmp_path: Path) -> None:
    for text in (gripper(), coupled_tree(np.random.default_rng(2), joints=6, followers=3)):
        arm = load_arm(write(tmp_path, text))
        q = np.random.default_rng(3).uniform(-1.0, 1.0, (4, arm.nv))
        drawn = draw(arm)
        poses, links = drawn.poses(q), arm.link_poses(q)
        for link, (_, body, pose) in enumerate(attachments(arm)):
            np.testing.assert_allclose(poses[:, body] @ pose, links[:, link], atol=1e-9)
        told = describe(drawn, arm.joint_names, np.arange(4.0), [PlayedMotion("A", "#000000", q)], None)
        assert [joint["name"] for joint in told["joints"]] == list(arm.joint_names)
        moving = told["arm"]["bodies"][1:]
        coupling = arm.tree.coupling
        assert [body["joint"] for body in moving] == coupling.coordinate.tolist()
        assert [body["ratio"] for body in moving] == coupling.ratio.tolist()
        assert [body["offset"] for body in moving] == coupling.offset.tolist()


def test_the_ur5_is_as_large_as_a_ur5() -> None:
    arm = load_arm("ur5")
    drawn = draw(arm)
    stretched = drawn.poses(np.zeros(6))
    points = np.concatenate(
        [body.mesh.vertices @ pose[:3, :3].T + pose[:3, 3] for body, pose in zip(drawn.bodies, stretched, strict=True)]
    )
    # Reach 850 mm to the centre of the wrist by the data sheet; shoulder at 89 mm; housings some 60 mm in radius.
    assert 0.85 < points[:, 0].max() < 0.95
    assert -0.004 < drawn.bodies[0].mesh.vertices[:, 2].min() <= 0.0  # the mesh begins 3 mm below the base frame
    assert 0.14 < points[:, 2].max() < 0.22
    assert sum(len(body.mesh.faces) for body in drawn.bodies) > 20_000
    assert len(np.unique(np.concatenate([body.mesh.colours for body in drawn.bodies]), axis=0)) >= 5


def test_an_arm_under_a_ceiling_hangs() -> None:
    standing, hanging = load_arm("ur5"), load_arm("ur5", gravity=[0.0, 0.0, 9.81])
    q = np.array([0.0, -np.pi / 2, 0.0, 0.0, 0.0, 0.0])  # stretched along the base's +z
    heights = []
    for arm in (standing, hanging):
        drawn = draw(arm, triangles=500)
        heights.append(float((drawn.upright @ drawn.poses(q)[-1])[2, 3]))
    assert heights[0] > 0.8
    assert heights[1] == pytest.approx(-heights[0], abs=1e-9)


def test_missing_meshes_become_a_skeleton_and_a_note(tmp_path: Path) -> None:
    lost = visual('<mesh filename="package://nowhere/lost.stl"/>')
    drawn = draw(load_arm(bent_arm(tmp_path, upper=lost, lower=visual('<box size="0.1 0.1 0.1"/>'))))
    assert len(drawn.notes) == 1
    assert "package://nowhere/lost.stl not found" in drawn.notes[0]
    upper, lower = drawn.bodies[1].mesh, drawn.bodies[2].mesh
    assert upper.vertices[:, 0].max() == pytest.approx(0.6, abs=1e-3), "the rail ends where the next joint's range does"
    np.testing.assert_allclose(np.ptp(lower.vertices, axis=0), 0.1, atol=1e-9)


def test_an_arm_without_visuals_is_a_skeleton(tmp_path: Path) -> None:
    drawn = draw(load_arm(bent_arm(tmp_path)))
    assert "no visuals" in drawn.notes[0]
    assert all(len(body.mesh.faces) for body in drawn.bodies)


@pytest.mark.parametrize(
    ("geometry", "extent"),
    [
        ('<box size="0.1 0.2 0.3"/>', (0.1, 0.2, 0.3)),
        ('<cylinder radius="0.1" length="0.5"/>', (0.2, 0.2, 0.5)),
        ('<sphere radius="0.15"/>', (0.3, 0.3, 0.3)),
        ('<capsule radius="0.1" length="0.5"/>', (0.2, 0.2, 0.7)),
    ],
)
def test_primitives_have_their_size_centre_and_colour(
    geometry: str, extent: tuple[float, float, float], tmp_path: Path
) -> None:
    blue = '<material name="own"><color rgba="0 0 1 1"/></material>'
    text = BENT.format(upper=visual(geometry, f'<origin xyz="1 2 3" rpy="0 0 0"/>{blue}'), lower="")
    shown, missing = read_visuals(text, RobotFiles(tmp_path))
    surface = join(shown["upper"])
    low, high = corners(surface)
    np.testing.assert_allclose(high - low, extent, rtol=0.01)
    np.testing.assert_allclose((high + low) / 2, (1, 2, 3), atol=1e-6)
    assert np.all(surface.colours == (0, 0, 255))
    assert not missing


def test_roll_pitch_yaw_turns_about_fixed_axes(tmp_path: Path) -> None:
    turned = '<origin rpy="1.5707963267948966 0 1.5707963267948966"/>'
    text = BENT.format(upper=visual('<box size="0.1 0.2 0.3"/>', turned), lower="")
    surface = join(read_visuals(text, RobotFiles(tmp_path))[0]["upper"])
    # First about x: (0.1, 0.3, 0.2); then about the fixed z: (0.3, 0.1, 0.2).
    np.testing.assert_allclose(np.ptp(surface.vertices, axis=0), (0.3, 0.1, 0.2), atol=1e-9)


def test_a_mirrored_mesh_keeps_its_outside_outside(tmp_path: Path) -> None:
    import trimesh

    trimesh.creation.box(extents=(1.0, 2.0, 3.0)).export(tmp_path / "box.stl")
    text = BENT.format(upper=visual('<mesh filename="box.stl" scale="-1 1 1"/>'), lower="")
    surface = join(read_visuals(text, RobotFiles(tmp_path))[0]["upper"])
    assert trimesh.Trimesh(surface.vertices, surface.faces).volume == pytest.approx(6.0)


def test_packages_are_found_by_their_folder_and_in_their_parent(tmp_path: Path) -> None:
    import trimesh

    package = tmp_path / "some_package"
    (package / "meshes").mkdir(parents=True)
    trimesh.creation.box(extents=(1.0, 2.0, 3.0)).export(package / "meshes" / "box.stl")
    text = BENT.format(upper=visual('<mesh filename="package://some_package/meshes/box.stl"/>'), lower="")
    for folder in (tmp_path, package):
        shown, missing = read_visuals(text, RobotFiles(tmp_path / "elsewhere", further=[folder]))
        assert not missing
        assert len(shown["upper"][0].faces) == 12


def sphere(radius: float = 0.1) -> Surface:
    from trimesh import creation

    ball = creation.icosphere(subdivisions=5, radius=radius)
    colours = np.where(ball.triangles_center[:, 2:] > 0, np.uint8([[200, 0, 0]]), np.uint8([[0, 0, 200]]))
    return Surface(np.asarray(ball.vertices), np.asarray(ball.faces), colours.astype(np.uint8))


def test_a_simplified_sphere_is_within_budget_and_still_round() -> None:
    fine = sphere()
    assert len(fine.faces) == 20480
    (coarse,) = simplify([fine], budget=3000)
    assert 1500 < len(coarse.faces) <= 3000
    radius = np.linalg.norm(coarse.vertices, axis=1)
    assert np.abs(radius - 0.1).max() < 0.002
    normals = coarse.normals / np.linalg.norm(coarse.normals.astype(float), axis=1, keepdims=True)
    angle = np.degrees(np.arccos(np.clip(np.sum(normals * coarse.vertices, axis=1) / radius, -1, 1)))
    assert angle.max() < 6.0
    corner = coarse.vertices[coarse.faces]
    areas = 0.5 * np.linalg.norm(np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), axis=1)
    red = coarse.colours[coarse.faces[:, 0], 0] == 200
    assert areas[red].sum() == pytest.approx(2 * np.pi * 0.01, rel=0.05), "half of the sphere stays red"


def test_what_is_within_budget_is_not_touched() -> None:
    fine = sphere()
    (same,) = simplify([fine], budget=30_000)
    assert len(same.faces) == len(fine.faces)


def test_edges_of_a_box_stay_sharp() -> None:
    from trimesh import creation

    box = creation.box(extents=(0.1, 0.2, 0.3))
    faces = np.asarray(box.faces)
    surface = Surface(np.asarray(box.vertices), faces, np.zeros((len(faces), 3), dtype=np.uint8))
    (drawn,) = simplify([surface], budget=100)
    assert np.all(np.sort(np.abs(drawn.normals), axis=1) == (0, 0, 127))
    assert len(drawn.vertices) == 24
