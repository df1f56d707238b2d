"""`asmc-pin inspect` says what is in the file, refused or not; commands that load an arm say its serious doubts."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from arm_urdf import inertial, joint, link, robot, two_joints, write
from urdf_kinds import FRICTION, KINDS, box, fixed, rod, serial

from asmc_pin import inspect, load_arm
from asmc_pin.cli import main
from asmc_pin.errors import ArmError, ParameterError
from asmc_pin.inspection.inspecting import serious_doubts
from asmc_pin.inspection.inspection_page import inspection_page


def ran(capsys: pytest.CaptureFixture[str], *arguments: str) -> tuple[int, str, str]:
    with pytest.raises(SystemExit) as stop:
        main(list(arguments))
    out, err = capsys.readouterr()
    assert isinstance(stop.value.code, int)
    return stop.value.code, out, err


def test_the_table_says_what_is_in_the_file(tmp_path: Path) -> None:
    text = robot(
        link("base"),
        link("upper", inertial(2.0, "0 0 0.1", rod(2.0, 0.2))),
        link("lower", inertial(1.0, "0.1 0 0", rod(1.0, 0.1))),
        joint("shoulder", "base", "upper", axis="0 0 2", xyz="0 0 0.4"),
        joint("elbow", "upper", "lower", "prismatic", axis="1 0 0", xyz="0 0 0.2", rpy="0 0 1.5707963267948966"),
        fixed("tool", "lower", inertial(1.0, "0.3 0 -0.05", rod(1.0, 0.1)), xyz="0 0 0.05"),
    )
    shoulder, elbow = inspect(write(tmp_path, text), armature=[0.3, 2.0]).joints
    assert (shoulder.hangs_on, elbow.hangs_on) == ("", "shoulder")
    assert shoulder.axis == pytest.approx([0, 0, 1])
    assert elbow.axis == pytest.approx([0, 1, 0], abs=1e-12)
    assert elbow.place == pytest.approx([0, 0, 0.6])
    assert elbow.links == ("lower", "tool")
    assert elbow.mass == 2.0
    assert elbow.com == pytest.approx([0.2, 0.0, 0.0], abs=1e-15)
    # The two rods along z lie 0.2 m apart on x: parallel axes add m d² about y and z.
    single = np.diag(rod(1.0, 0.1))
    wanted = 2.0 * single + 2.0 * 0.1**2 * np.array([0.0, 1.0, 1.0])
    assert elbow.radii == pytest.approx(np.sort(np.sqrt(wanted / 2.0)), rel=1e-12)
    assert elbow.armature == 2.0
    assert shoulder.limits == (-2.0, 2.0, 50.0, 3.0)


def test_a_refused_arm_is_shown_all_the_same_with_the_reason(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = write(tmp_path, KINDS["impossible links"].text)
    page = tmp_path / "page.html"
    status, out, err = ran(capsys, "inspect", str(path), "--html", str(page))
    assert status == 1
    assert "REFUSED by other commands" in out
    assert out.count("breaks the triangle inequality") == 3
    assert "--repair" in out
    assert "j3" in out
    assert not page.exists()
    assert "not drawn" in err
    with pytest.raises(ArmError, match="is refused, so it cannot be drawn"):
        inspect(path).write_page(page)
    status, out, _ = ran(capsys, "inspect", str(path), "--repair")
    assert status == 0
    assert "repaired inertia: tensor of link1" in out


BROKEN = {
    "swapped limits": ('lower="-2" upper="2"', 'lower="2" upper="-2"', "lower limit 2 is above its upper limit -2"),
    "no axis": ('<axis xyz="0 1 0"/>', '<axis xyz="0 0 0"/>', "its axis is zero"),
    "negative friction": ('friction="0.2"', 'friction="-0.2"', "friction -0.2 is negative"),
    "ring": ('name="j1" type="revolute">', 'name="j1" type="revolute"><mimic joint="j1"/>', "'j1' → 'j1'"),
    "follows nobody": ('name="j2" type="revolute">', 'name="j2" type="revolute"><mimic joint="jx"/>', "joint 'jx'"),
    "negative mass": ('value="3.0"', 'value="-3.0"', "its mass is -3 kg"),
}


@pytest.mark.parametrize("names", [(name,) for name in BROKEN] + [tuple(BROKEN)], ids="+".join)
def test_what_can_be_told_is_shown_with_all_that_it_is_refused_for_at_once(
    names: tuple[str, ...], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = serial(limit=FRICTION.replace("0.4", "0.3"))
    for name in names:
        old, new, _ = BROKEN[name]
        assert old in text
        text = text.replace(old, new, 1)
    # A doubt that has nothing to do with what is wrong is said beside it.
    path = write(tmp_path, text.replace('rpy="0 0 0"', 'rpy="0 0 90"'))
    status, out, _ = ran(capsys, "inspect", str(path))
    assert status == 1
    assert all(row in out for row in ("j1 ", "j2 ", "j3 "))
    assert "REFUSED by other commands" in out
    assert "looks like degrees" in out
    for name in names:
        assert BROKEN[name][2] in out
    with pytest.raises(ArmError) as refusal:
        load_arm(path)
    assert str(refusal.value) == inspect(path).refusal
    if len(names) > 1:
        assert f"{len(names)} faults:" in out


def test_numbers_that_are_none_are_all_named_at_once(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = serial().replace('mass value="4.0"', 'mass value="four"').replace('mass value="3.0"', 'mass value="nan"')
    status, out, err = ran(capsys, "inspect", str(write(tmp_path, text)))
    assert (status, out) == (2, "")
    assert '<mass value="four"> is not a number' in err
    assert '<mass value="nan"> is not a finite number' in err


def test_a_follower_is_shown_with_how_it_follows(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = serial().replace(
        'name="j3" type="revolute">', 'name="j3" type="revolute"><mimic joint="j2" multiplier="-0.5" offset="0.1"/>'
    )
    path = str(write(tmp_path, text))
    assert "follows -0.5 · j2 + 0.1" in ran(capsys, "inspect", path)[1]
    followers = {each["joint"]: each for each in json.loads(ran(capsys, "inspect", path, "--json")[1])["joints"]}
    assert [followers["j3"][key] for key in ("follows", "multiplier", "offset")] == ["j2", -0.5, 0.1]
    assert [followers["j2"][key] for key in ("follows", "multiplier", "offset")] == [None, None, None]


def test_a_body_that_cannot_be_makes_no_doubt_of_the_joints_that_carry_it(tmp_path: Path) -> None:
    text = serial(tensor=lambda k, mass, length: rod(mass, length) * (-2.0 if k == 2 else 1.0))
    found = inspect(write(tmp_path, text))
    assert "not positive semidefinite" in found.refusal
    assert {doubt.kind for doubt in found.doubts} == set()


@pytest.mark.parametrize(
    ("mass", "scale", "said"),
    [(2.0, 1.0, ""), (5000.0, 1.0, "steel"), (5.0, 1000.0, "hollow shell"), (0.001, 1.0, "hollow")],
)
def test_an_estimate_with_a_density_that_no_robot_has_is_doubted(
    mass: float, scale: float, said: str, tmp_path: Path
) -> None:
    shape = box(f"{0.05 * scale} {0.05 * scale} {0.2 * scale}", f"0 0 {0.1 * scale}")
    text = robot(link("base"), link("l1", shape), joint("j1", "base", "l1", axis="0 1 0"))
    path = write(tmp_path, text)
    found = [doubt.text for doubt in inspect(path, estimate_inertia=mass).doubts if doubt.kind == "density"]
    assert bool(found) == bool(said)
    assert all(said in text for text in found)
    # Every command that loads the arm says it.
    assert [d.text for d in serious_doubts(load_arm(path, estimate_inertia=mass)) if d.kind == "density"] == found


def test_help_of_a_command_for_one_arm_offers_no_ranges(capsys: pytest.CaptureFixture[str]) -> None:
    assert "LO:HI" not in ran(capsys, "inspect", "--help")[1]
    assert "LO:HI" in ran(capsys, "bounds", "--help")[1]


def test_its_json_is_all_of_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = write(tmp_path, KINDS["limits in degrees"].text.replace('upper="170"', 'upper="1e9"', 1))
    status, out, _ = ran(capsys, "inspect", str(path), "--json", "--lock", "j2=0")
    assert status == 0
    said = json.loads(out)
    assert [each["joint"] for each in said["joints"]] == ["j1", "j3"]
    assert said["joints"][0]["upper"] is None
    assert said["joints"][0]["body"]["links"] == ["link1", "link2"]
    assert said["locked"] == {"j2": 0.0}
    assert said["refused"] is None
    assert [doubt["kind"] for doubt in said["doubts"] if doubt["serious"]] == ["limits"]


def test_every_loading_command_says_serious_doubts_and_where_to_look(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = str(write(tmp_path, KINDS["tensors in g·mm²"].text))
    for command in (("verify", path, "--mbar", "0.1", "--samples", "8"), ("agree", path)):
        _, _, err = ran(capsys, *command)
        assert "doubtful: inertia of link1, link2, link3 looks like g·mm²" in err
        assert "asmc-pin inspect " in err
    good = str(write(tmp_path, KINDS["seven joints"].text, "good.urdf"))
    _, _, err = ran(capsys, "verify", good, "--mbar", "0.1", "--samples", "8")
    assert "doubt" not in err


def test_repair_is_no_way_around_a_doubt(tmp_path: Path) -> None:
    broken = serial(tensor=lambda _k, mass, length: 1e9 * (rod(mass, length) + np.diag([0.0, 0.0, 0.2])))
    found = inspect(write(tmp_path, broken), repair=True)
    assert "tensor unit" in {doubt.kind for doubt in found.doubts}
    assert found.provisos


def test_a_range_means_nothing_to_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    status, out, err = ran(capsys, "inspect", str(write(tmp_path, two_joints())), "--payload", "0:2")
    assert (status, out) == (2, "")
    assert "--payload: one value expected here" in err
    with pytest.raises(ParameterError):
        inspect(write(tmp_path, two_joints()), lock={"nothing": 0.0})


@pytest.mark.parametrize("name", ["ur5", "two_link", "panda"])
def test_the_page_opens_without_a_network_and_is_the_same_each_time(name: str) -> None:
    page = inspection_page(load_arm(name))
    assert "connect-src" not in page
    assert "default-src 'none'" in page
    assert "Orange: centres of mass" in page
    assert page == inspection_page(load_arm(name))


def test_known_doubts_of_shipped_arms() -> None:
    kinds = {
        name: {d.kind for d in inspect(name).doubts if d.serious} for name in ("ur5", "panda", "two_link", "xarm7")
    }
    # docs/arms.md: the URDF's wrists have inertias of bodies many times their size.
    assert "radius of gyration" in kinds["ur5"]
    assert kinds["two_link"] == kinds["xarm7"] == set()
