"""`asmc-pin inspect` says what is in the file, refused or not; commands that load an arm say its serious doubts."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from arm_urdf import inertial, joint, link, robot, two_joints, write
from urdf_kinds import KINDS, fixed, rod, serial

from asmc_pin import inspect, load_arm
from asmc_pin.cli import main
from asmc_pin.errors import ArmError, ParameterError
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
