"""A picture never costs a run: what cannot be drawn as written is grey or left out, and a warning says so."""

import sys
import warnings
from pathlib import Path

import numpy as np
import pytest
from hostile import BODY, asked, chain
from short_experiment import SHORT

from asmc_pin.arms import load_arm
from asmc_pin.viewer import draw
from asmc_pin.viewer.drawing.drawn_bodies import DrawingWarning
from asmc_pin.viewer.drawing.surface import PLAIN

BOX = '<geometry><box size="0.1 0.1 0.1"/></geometry>'


def visual(inside: str) -> str:
    return f"<visual>{inside}</visual>"


def coloured(rgba: str) -> str:
    return visual(f'{BOX}<material name="m"><color rgba="{rgba}"/></material>')


def arm_with(folder: Path, inside: str, extra: str = "") -> Path:
    path = folder / "arm.urdf"
    path.write_text(chain(2, body=BODY + inside, extra=extra))
    return path


def drawn(path: Path) -> tuple[list[str], np.ndarray]:
    """The notes beside a picture, and the colours of its last body's triangles."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        picture = draw(load_arm(path), 2000)
    told = [str(item.message) for item in caught if item.category is DrawingWarning]
    assert len(told) == len([note for note in picture.notes if "no visuals" not in note])
    for body in picture.bodies:
        assert np.isfinite(body.mesh.vertices).all()
    return told, picture.bodies[-1].mesh.colours


ODD_COLOURS = ["red", "1 0", "1 0 0 1 1", "nan 0 0 1", "inf 0 0 1", "1,0,0", "１ 0 0", "#ff0000", "&#10;", "x" * 10_000]


@pytest.mark.parametrize("rgba", ODD_COLOURS)
def test_a_colour_that_is_none_is_grey(rgba: str, tmp_path: Path) -> None:
    told, colours = drawn(arm_with(tmp_path, coloured(rgba)))
    assert (colours == PLAIN).all()
    assert "drawn in grey" in told[0]
    assert len(told[0]) < 1000


@pytest.mark.parametrize("rgba", ["2 -1 0 1", "1 0 0", "1 0 0 1"])
def test_a_colour_beyond_its_range_is_the_nearest_one(rgba: str, tmp_path: Path) -> None:
    told, colours = drawn(arm_with(tmp_path, coloured(rgba)))
    assert not told
    assert (colours == (255, 0, 0)).all()


def test_a_material_of_that_kind_which_others_name_is_grey_too(tmp_path: Path) -> None:
    named = visual(f'{BOX}<material name="m"/>')
    _, colours = drawn(arm_with(tmp_path, named, '<material name="m"><color rgba="red"/></material>'))
    assert (colours == PLAIN).all()


@pytest.mark.parametrize("origin", ['xyz="a b c"', 'xyz="0 0"', 'rpy="nan 0 0"', 'xyz="1e400 0 0"', 'rpy="0 0 0 0"'])
def test_a_visual_at_no_place_is_grey_at_its_link(origin: str, tmp_path: Path) -> None:
    blue = '<material name="m"><color rgba="0 0 1 1"/></material>'
    told, colours = drawn(arm_with(tmp_path, visual(f"<origin {origin}/>{BOX}{blue}")))
    assert (colours == PLAIN).all()
    assert "drawn at the link's frame" in told[0]


LEFT_OUT = {
    "a box of two sides": '<box size="1 1"/>',
    "a box of a word": '<box size="big"/>',
    "a ball of no number": '<sphere radius="nan"/>',
    "a ball beyond all": '<sphere radius="1e300"/>',
    "a cylinder of no length": '<cylinder radius="0.1" length="x"/>',
    "no mesh": '<mesh filename="none.stl"/>',
    "no name": "<mesh/>",
    "a mesh of text": '<mesh filename="text.stl"/>',
    "a mesh of noise": '<mesh filename="noise.dae"/>',
    "an empty mesh": '<mesh filename="empty.obj"/>',
    "a mesh that claims a billion": '<mesh filename="claims.stl"/>',
    "a folder": '<mesh filename="folder.stl"/>',
    "a scale of zero": '<mesh filename="good.stl" scale="0 0 0"/>',
    "a scale of NaN": '<mesh filename="good.stl" scale="nan 1 1"/>',
    "a scale of two": '<mesh filename="good.stl" scale="1 1"/>',
    "a scale of words": '<mesh filename="good.stl" scale="a b c"/>',
    "a scale beyond all": '<mesh filename="good.stl" scale="1e300 1 1"/>',
    "a network address": '<mesh filename="http://127.0.0.1:9/x.stl"/>',
}


@pytest.mark.parametrize("case", LEFT_OUT)
def test_a_shape_that_is_none_is_left_out_and_named(case: str, tmp_path: Path) -> None:
    import trimesh

    trimesh.creation.box(extents=(1.0, 2.0, 3.0)).export(tmp_path / "good.stl")
    (tmp_path / "text.stl").write_text("no mesh at all")
    (tmp_path / "noise.dae").write_bytes(bytes(range(256)) * 10)
    (tmp_path / "empty.obj").write_text("")
    (tmp_path / "claims.stl").write_bytes(bytes(80) + (10**9).to_bytes(4, "little") + bytes(50))
    (tmp_path / "folder.stl").mkdir()
    told, _ = drawn(arm_with(tmp_path, visual(f"<geometry>{LEFT_OUT[case]}</geometry>")))
    assert "link 'l1'" in told[0]
    assert "left out" in told[0]
    assert "(and 1 more)" in told[0]


def test_a_texture_that_is_missing_leaves_the_mesh_in_grey_or_its_own_colour(tmp_path: Path) -> None:
    (tmp_path / "m.obj").write_text(
        "mtllib m.mtl\nusemtl a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n"
    )
    (tmp_path / "m.mtl").write_text("newmtl a\nmap_Kd ../../../../none.png\n")
    _, colours = drawn(arm_with(tmp_path, visual('<geometry><mesh filename="m.obj"/></geometry>')))
    assert len(colours)


EXPERIMENT = SHORT.replace('"two_link"', '"arm.urdf"').replace("duration = 0.2", "duration = 0.02")


@pytest.mark.long
def test_a_comparison_runs_through_with_a_colour_that_is_a_word(tmp_path: Path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    arm_with(tmp_path, coloured("red"))
    Path("e.toml").write_text(EXPERIMENT)
    said = asked("compare", "e.toml", "--out", "out")
    assert said.status == 0, said
    assert "drawn in grey" in said.err
    assert "drawn in grey" in Path("out/report.html").read_text()
    said = asked("view", "out", "--html", "page.html")
    assert said.status == 0, said
    assert "drawn in grey" in Path("page.html").read_text()
    said = asked("verify", "arm.urdf", "--mbar", "0.01", "--samples", "20", "--report", "condition.html")
    assert said.status in (0, 1), said
    assert "drawn in grey" in Path("condition.html").read_text()


@pytest.mark.parametrize("step", ["draw_figures", "report_html", "draw_theorems"])
def test_a_fault_in_a_picture_leaves_the_run_and_a_warning(step: str, tmp_path: Path, monkeypatch) -> None:
    from asmc_pin.results.result_folder import load_result

    def fail(*_args: object, **_kwargs: object) -> None:
        raise KeyError("some fault\nof ours")

    home = {"draw_theorems": "asmc_pin.study.run_monitors", "report_html": "asmc_pin.pages.comparison_page"}
    import asmc_pin.pages.comparison_page
    import asmc_pin.study.comparison_files  # noqa: F401

    monkeypatch.setattr(sys.modules[home.get(step, "asmc_pin.study.comparison_files")], step, fail)
    (tmp_path / "e.toml").write_text(SHORT.replace("duration = 0.2", "duration = 0.02"))
    said = asked("compare", tmp_path / "e.toml", "--out", tmp_path / "out")
    assert said.status == 0, said
    assert "could not be drawn (KeyError: 'some fault" in said.err
    assert "the result itself is whole" in said.err
    assert load_result(tmp_path / "out").claims is not None
    assert ("report.html" in said.out) == (step != "report_html")


def test_names_with_the_signs_of_formulas_are_drawn_as_they_are(tmp_path: Path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    path = arm_with(tmp_path, "")
    path.write_text(path.read_text().replace('"j0"', '"$\\frac$"').replace('"j1"', '"a_{$^$"'))
    Path("e.toml").write_text(EXPERIMENT.replace("[controllers.PPC]", "[controllers.'$\\frac{$_^']"))
    said = asked("compare", "e.toml", "--out", "out")
    assert said.status == 0, said
    assert "could not be drawn" not in said.err
    said = asked("verify", "arm.urdf", "--mbar", "0.01", "--samples", "20", "--report", "condition.html")
    assert said.status in (0, 1), said
