"""Inertias estimated from shapes and a mass: exact where the shape is, and marked wherever the arm appears."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import trimesh
from arm_urdf import inertial, joint, link, robot, two_joints, write
from lxml import etree

from asmc_pin import agree, check, compare, load_arm, load_experiment, load_result, verify
from asmc_pin._typing import Array
from asmc_pin.arms.sources.robot_files import RobotFiles
from asmc_pin.arms.urdf.solid_shapes import Solid, solids_of
from asmc_pin.cli import main
from asmc_pin.condition.certificate import certify
from asmc_pin.errors import ArmError, ParameterError
from asmc_pin.pages.condition_page import write_condition_report


def shape(geometry: str, kind: str = "visual", origin: str = "") -> str:
    return f"<{kind}>{origin}<geometry>{geometry}</geometry></{kind}>"


BOX = shape('<box size="0.4 0.1 0.2"/>', origin='<origin xyz="0.2 0 0" rpy="0 0 0"/>')
BALL = shape('<sphere radius="0.1"/>', "collision")


def bare_arm(upper: str = BOX, lower: str = BALL, base: str = "", more: str = "") -> str:
    return robot(
        link("base", base),
        link("upper", upper),
        link("lower", lower),
        joint("shoulder", "base", "upper", axis="0 1 0"),
        joint("elbow", "upper", "lower", axis="0 1 0", xyz="0.4 0 0"),
        more,
    )


def solid(content: str, folder: Path = Path()) -> tuple[Solid, int]:
    found, problems = solids_of({"x": etree.fromstring(f"<link>{content}</link>")}, RobotFiles(folder))
    assert not problems
    return found["x"].solid, found["x"].hulls


def test_a_total_mass_is_shared_by_volume_and_gives_the_inertias_of_these_shapes(tmp_path: Path) -> None:
    arm = load_arm(write(tmp_path, bare_arm()), estimate_inertia=10.0)
    box, ball = 0.4 * 0.1 * 0.2, 4.0 / 3.0 * math.pi * 0.1**3
    masses = [10.0 * box / (box + ball), 10.0 * ball / (box + ball)]
    b = np.diag([0.1**2 + 0.2**2, 0.4**2 + 0.2**2, 0.4**2 + 0.1**2]) * masses[0] / 12.0
    s = np.eye(3) * 0.4 * masses[1] * 0.1**2
    by_hand = bare_arm(inertial(masses[0], "0.2 0 0", b), inertial(masses[1], "0 0 0", s))
    q = np.array([0.4, -0.9])
    expected = load_arm(write(tmp_path, by_hand, "hand.urdf")).mass_matrix(q)
    np.testing.assert_allclose(arm.mass_matrix(q), expected, rtol=1e-13)


def moments(content: str, mesh: trimesh.Trimesh) -> tuple[Array, Array]:
    exact, hulls = solid(content)
    assert hulls == 0
    assert exact.volume == pytest.approx(mesh.volume, rel=3e-3)
    np.testing.assert_allclose(exact.centre, mesh.center_mass, atol=1e-9)
    return exact.inertia, np.asarray(mesh.moment_inertia)


@pytest.mark.parametrize(
    ("content", "mesh"),
    [
        ('<box size="0.1 0.2 0.3"/>', lambda: trimesh.creation.box((0.1, 0.2, 0.3))),
        ('<sphere radius="0.2"/>', lambda: trimesh.creation.icosphere(subdivisions=5, radius=0.2)),
        ('<cylinder radius="0.1" length="0.5"/>', lambda: trimesh.creation.cylinder(0.1, 0.5, sections=256)),
        ('<capsule radius="0.1" length="0.5"/>', lambda: trimesh.creation.capsule(0.5, 0.1, count=[128, 128])),
    ],
)
def test_primitive_shapes_have_the_moments_of_their_fine_meshes(
    content: str, mesh: Callable[[], trimesh.Trimesh]
) -> None:
    made = mesh()
    made.apply_translation(-made.center_mass)
    exact, fine = moments(shape(content), made)
    np.testing.assert_allclose(exact, fine, rtol=6e-3, atol=1e-9)


def test_an_origin_turns_and_shifts_and_shapes_add_up() -> None:
    lying = shape('<cylinder radius="0.1" length="0.5"/>', origin='<origin xyz="1 2 3" rpy="0 1.5707963267948966 0"/>')
    one, _ = solid(lying)
    upright, _ = solid(shape('<cylinder radius="0.1" length="0.5"/>'))
    np.testing.assert_allclose(np.diag(one.inertia), np.diag(upright.inertia)[[2, 1, 0]], rtol=1e-12)
    np.testing.assert_allclose(one.centre, [1.0, 2.0, 3.0])
    halves, _ = solid(
        "".join(shape('<box size="0.2 0.1 0.1"/>', origin=f'<origin xyz="{x} 0 0"/>') for x in (-0.1, 0.1))
    )
    whole, _ = solid(shape('<box size="0.4 0.1 0.1"/>'))
    np.testing.assert_allclose(halves.inertia, whole.inertia, rtol=1e-12, atol=1e-18)


def test_a_closed_mesh_is_itself_and_of_an_open_one_the_convex_hull(tmp_path: Path) -> None:
    box = trimesh.creation.box((1.0, 2.0, 3.0))
    inside_out, no_lid = box.copy(), box.copy()
    inside_out.invert()
    no_lid.update_faces(np.arange(len(box.faces)) > 1)
    # A shape whose hull is larger than itself, closed: it must not be hulled.
    ring = trimesh.creation.annulus(r_min=0.5, r_max=1.0, height=1.0, sections=256)
    for name, mesh in {"closed": box, "inside_out": inside_out, "no_lid": no_lid, "ring": ring}.items():
        mesh.export(tmp_path / f"{name}.stl")
    for name, volume, hulls in (
        ("closed", 6.0, 0),
        ("inside_out", 6.0, 0),
        ("no_lid", 6.0, 1),
        ("ring", 0.75 * math.pi, 0),
    ):
        found, taken = solid(shape(f'<mesh filename="{name}.stl"/>'), tmp_path)
        assert (found.volume, taken) == (pytest.approx(volume, rel=1e-3), hulls)
        if name != "ring":
            np.testing.assert_allclose(found.inertia, box.moment_inertia, rtol=1e-6, atol=1e-6)
    scaled, _ = solid(shape('<mesh filename="closed.stl" scale="0.001 -0.001 0.001"/>'), tmp_path)
    assert scaled.volume == pytest.approx(6e-9, rel=1e-6)
    assert np.linalg.eigvalsh(scaled.inertia)[0] > 0.0
    text = bare_arm(upper=shape('<mesh filename="no_lid.stl"/>'))
    told = load_arm(write(tmp_path, text), estimate_inertia=3).provisos[0].text
    assert "convex hulls in place of meshes that are not closed: 'upper'" in told


def test_masses_by_link_replace_what_the_file_says(tmp_path: Path) -> None:
    content = two_joints().replace('<link name="upper">', f'<link name="upper">{BOX}')
    arm = load_arm(write(tmp_path, content), estimate_inertia={"upper": 4.0})
    assert arm.tree.mass.tolist() == [4.0, 1.0]
    assert arm.tree.com[0].tolist() == [0.2, 0.0, 0.0]
    assert "'upper' 4 kg; uniform density in each link; from visual shapes: all" in arm.provisos[0].text


def test_what_has_mass_keeps_it_and_a_frame_beside_a_mass_gets_none(tmp_path: Path) -> None:
    # The elbow moves a link without inertia on which a body with inertia is fixed; and helper links have shapes too.
    text = bare_arm(
        upper=BOX,
        lower=BALL,
        base=BOX,
        more=link("body", inertial(2.0))
        + joint("weld", "lower", "body", "fixed")
        + link("padding", shape('<sphere radius="1"/>', "collision"))
        + joint("pad", "upper", "padding", "fixed"),
    )
    arm = load_arm(write(tmp_path, text), estimate_inertia=6.0)
    # Of 6 kg half are the base's, whose shape is the same; the padding is no visible shape.
    assert arm.tree.mass.tolist() == [pytest.approx(3.0), 2.0]
    assert "padding" not in arm.provisos[0].text


@pytest.mark.parametrize(
    ("text", "masses", "said"),
    [
        (two_joints(), 3.0, "every link that a joint of arm.urdf moves has an inertia"),
        (bare_arm(), 0.0, "0.0 given, a mass above zero expected, kg"),
        (bare_arm(), True, "True given, a mass above zero"),
        (bare_arm(), {"uper": 1.0}, "no link 'uper' in arm.urdf; did you mean 'upper'"),
        (bare_arm(), {"upper": -1.0}, "link 'upper': -1.0 given"),
        (bare_arm(), {}, "give a total mass in kg, or link = kg"),
        (bare_arm(), {"base": 1.0}, "no inertia can be estimated for link 'base': it has neither visual nor collision"),
        (bare_arm(), {"upper": 1.0}, "moves link 'lower', which carries no inertia.*--estimate-inertia KG"),
        (
            bare_arm(lower=shape('<mesh filename="package://gone/x.stl"/>')),
            1.0,
            r"visual of link 'lower': package://gone/x.stl not found \(say where the package lies: --package gone=DIR",
        ),
        (bare_arm(lower=shape('<box size="1 0 1"/>')), 1.0, '<box size="1 0 1"> encloses nothing'),
        (bare_arm(lower=shape("<plane/>")), 1.0, "<plane> is no shape whose volume is known"),
        (bare_arm(upper="", lower=""), 1.0, "no link of arm.urdf that is without inertia has a shape"),
    ],
)
def test_what_cannot_be_estimated_is_said(text: str, masses: object, said: str, tmp_path: Path) -> None:
    with pytest.raises((ArmError, ParameterError), match=said):
        load_arm(write(tmp_path, text), estimate_inertia=masses)  # type: ignore[arg-type]


def test_an_estimate_is_marked_wherever_the_arm_appears(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = write(tmp_path, bare_arm())
    arm = load_arm(path, estimate_inertia=10.0, armature=5.0)
    assert "estimated inertia: 10 kg over 2 links in proportion to volume" in str(arm)
    assert arm.sha256 == hashlib.sha256(path.read_bytes()).hexdigest()
    report = verify(arm, 5.0, samples=100)
    assert report.headline().startswith("arm with estimated inertia, armature 5 kg·m² at every joint: ")
    assert report.to_json_dict()["provisos"][0]["kind"] == "estimated inertia"
    write_condition_report(report, arm, tmp_path / "page.html")
    assert "Estimated inertia" in (tmp_path / "page.html").read_text(encoding="utf-8")
    # The checker reads the URDF with the inertias put in, MuJoCo too.
    result = check(certify(arm, 5.0, budget=30.0, gap=0.9).save(tmp_path / "a.cert"))
    assert (result.valid, result.verdict) == (True, "holds")
    assert "Estimated inertia: as the certificate's maker says: 10 kg over 2 links" in str(result)
    assert agree(load_arm(path, estimate_inertia=10.0)).verdict == "agrees"
    options = ["--mbar", "1", "--samples", "10", "--json", "--estimate-inertia", "upper=8"]
    with pytest.raises(SystemExit):
        main(["verify", str(path), *options, "--estimate-inertia", "lower=2"])
    out, err = capsys.readouterr()
    assert "'upper' 8 kg, 'lower' 2 kg; uniform density in each link" in json.loads(out)["provisos"][0]["text"]
    assert "warning: estimated inertia: " in err


def test_a_comparison_carries_the_urdf_that_it_computed_with(tmp_path: Path) -> None:
    write(tmp_path, bare_arm())
    (tmp_path / "e.toml").write_text(
        'name = "e"\nperiod = 0.002\nduration = 0.02\n'
        'arm = { source = "arm.urdf", estimate_inertia = 10.0 }\n'
        'reference = { kind = "quintic", start = [0.0, 0.5], targets = [[0.0, 0.5]], times = [0.02], move = 0.02 }\n'
        '[controllers.a]\nlaw = "ppc"\nmbar = 0.1\nks = 1.0\nbeta = 1.0\n'
    )
    experiment = load_experiment(tmp_path / "e.toml")
    compare(experiment, tmp_path / "out")
    told = load_result(tmp_path / "out").provenance
    assert told["arm"]["provisos"][0]["kind"] == "estimated inertia"
    carried = (tmp_path / "out" / "computed_arm.urdf").read_bytes()
    assert told["arm"]["urdf_sha256"] == told["files"]["computed_arm.urdf"] == hashlib.sha256(carried).hexdigest()
    (tmp_path / "again.urdf").write_bytes(carried)
    again = load_arm(tmp_path / "again.urdf")
    q = np.array([0.2, 0.7])
    assert np.array_equal(again.mass_matrix(q), experiment.build_arm().mass_matrix(q))
    assert "with estimated inertia" in (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
