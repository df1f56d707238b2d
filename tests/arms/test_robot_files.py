"""Files as people have them: xacro, namespaces, old versions of XML, packages and meshes, names of descriptions."""

from __future__ import annotations

import hashlib
import json
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from arm_urdf import two_joints, write
from paths import CASES

from asmc_pin import compare, load_arm, load_experiment, load_result
from asmc_pin.arms.sources import named_descriptions
from asmc_pin.arms.sources.robot_files import RobotFiles
from asmc_pin.arms.urdf import urdf_document
from asmc_pin.cli import main
from asmc_pin.condition.certificate import certify
from asmc_pin.condition.checker import check
from asmc_pin.errors import ArmError, ParameterError
from asmc_pin.viewer.drawing.visuals import read_visuals

XMLNS = 'xmlns:xacro="http://www.ros.org/wiki/xacro"'
VISUAL = '<visual><geometry><mesh filename="{}"/></geometry></visual>'
BOX = '<visual><geometry><box size="1 1 1"/></geometry></visual>'
BARE = two_joints().replace('<link name="base">', f'<link name="base">{BOX}')


def same_dynamics(one: pin.Model, other: pin.Model) -> None:
    q = np.array([0.3, -0.7])
    np.testing.assert_allclose(pin.crba(one, one.createData(), q), pin.crba(other, other.createData(), q), rtol=1e-14)


def xacro_package(folder: Path, name: str = "my_arm") -> Path:
    """A package whose file needs an argument, a file beside it, and one that it finds through the package's name."""
    (folder / "urdf" / "inc").mkdir(parents=True)
    (folder / "meshes").mkdir()
    (folder / "package.xml").write_text(f"<package><name>{name}</name></package>")
    (folder / "meshes" / "base.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    (folder / "urdf" / "inc" / "tip.xacro").write_text(
        f'<robot {XMLNS}><xacro:property name="tip" value="0.1"/></robot>'
    )
    (folder / "masses.yaml").write_text("upper: 2.0\n")
    mesh = VISUAL.format(f"file://$(find {name})/meshes/base.obj")
    mass = "xacro.load_yaml('$(find my_arm)/masses.yaml')['upper']"
    text = two_joints().replace('<robot name="r">', f'<robot name="$(arg name)" {XMLNS}>')
    text = text.replace('<mass value="2.0"/>', f'<mass value="${{{mass}}}"/>')
    text = text.replace('xyz="0.1 0 0.3"', 'xyz="${tip} 0 $(arg height)"')
    text = text.replace('<link name="base">', f'<link name="base">{mesh}')
    head = '<xacro:arg name="height" default="0.3"/><xacro:include filename="inc/tip.xacro"/>'
    file = folder / "urdf" / "arm.urdf.xacro"
    file.write_text(text.replace(">\n", f">\n{head}\n", 1).replace("$(find my_arm)", f"$(find {name})"))
    return file


def test_a_xacro_file_is_the_arm_that_it_expands_to(tmp_path: Path) -> None:
    file = xacro_package(tmp_path / "anything")
    arm = load_arm(file, xacro={"name": "mine", "height": 0.3})
    same_dynamics(arm.model, load_arm(write(tmp_path, two_joints())).model)
    assert arm.name == "mine"
    assert arm.sha256 == hashlib.sha256(file.read_bytes()).hexdigest()
    # What was computed with goes along, names nobody's folders, and shows the same meshes elsewhere.
    assert str(tmp_path) not in arm.urdf_text
    assert "package://my_arm/meshes/base.obj" in arm.urdf_text
    shown, problems = read_visuals(arm.urdf_text, arm.files)
    assert list(shown) == ["base"]
    assert not problems
    (proviso,) = arm.provisos
    assert proviso.kind == "expanded xacro"
    for part in ("name=mine, height=0.3", "tip.xacro (SHA-256 ", "masses.yaml (SHA-256 "):
        assert part in proviso.text
    assert arm.replace(payload=1.0).provisos == arm.provisos


def test_what_a_xacro_file_lacks_is_asked_for(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = xacro_package(tmp_path / "p")
    with pytest.raises(ArmError, match=r"needs the argument 'name'; give it: --xacro name=VALUE"):
        load_arm(file)
    with pytest.raises(ParameterError, match=r"no argument 'hieght' in arm.urdf.xacro; did you mean 'height'\\?"):
        load_arm(file, xacro={"name": "r", "hieght": "1"})
    # xacro itself takes no argument without a default; here it is one that has to be given.
    bare = file.with_name("bare.urdf.xacro")
    bare.write_text(file.read_text().replace('name="height" default="0.3"', 'name="height"'))
    with pytest.raises(ArmError, match=r"needs the argument 'height'; give it: --xacro height=VALUE"):
        load_arm(bare, xacro={"name": "r"})
    assert load_arm(bare, xacro={"name": "r", "height": "0.3"}).nv == 2
    with pytest.raises(ParameterError, match=r"no argument 'hieght'.*did you mean 'height'"):
        load_arm(bare, xacro={"name": "r", "height": "0.3", "hieght": "1"})
    alone = file.rename(tmp_path / "arm.xacro")
    (tmp_path / "inc").mkdir()
    (tmp_path / "p" / "urdf" / "inc" / "tip.xacro").rename(tmp_path / "inc" / "tip.xacro")
    monkeypatch.delenv("ROS_PACKAGE_PATH", raising=False)
    monkeypatch.delenv("AMENT_PREFIX_PATH", raising=False)
    with pytest.raises(ArmError, match=r"needs the package 'my_arm', .* --package my_arm=DIR"):
        load_arm(alone, xacro={"name": "r"})
    assert load_arm(alone, xacro={"name": "r"}, package={"my_arm": tmp_path / "p"}).nv == 2
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path))
    assert load_arm(alone, xacro={"name": True}).nv == 2
    with pytest.raises(ParameterError, match="is no xacro file and takes no arguments"):
        load_arm("two_link", xacro={"name": "r"})
    with pytest.raises(ParameterError, match="is no folder"):
        load_arm("two_link", package={"my_arm": tmp_path / "nowhere"})


def test_a_certificate_of_a_xacro_file_carries_the_expanded_urdf(tmp_path: Path) -> None:
    arm = load_arm(xacro_package(tmp_path / "p"), xacro={"name": "r"}, armature=1.0)
    saved = certify(arm, 1.0, budget=30.0, gap=0.5).save(tmp_path / "a.cert")
    result = check(saved)
    assert (result.valid, result.verdict) == (True, "holds")
    told = result.to_json_dict()["provisos"]
    assert told[0]["kind"] == "expanded xacro"
    assert told[0]["text"].startswith("as the certificate's maker says: arm.urdf.xacro with name=r")


def test_the_command_line_and_experiments_take_the_same(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = xacro_package(tmp_path / "p" / "my_arm")
    with pytest.raises(SystemExit) as stop:
        main(["verify", str(file), "--mbar", "0.1", "--xacro", "name=r", "--xacro", "height="])
    assert (stop.value.code, capsys.readouterr().err.count("xyz")) == (2, 2)  # taken, and no number at either place
    given = ["--xacro", "height=0.2", "--xacro", "name=mine", "--package", f"my_arm={file.parent.parent}"]
    with pytest.raises(SystemExit) as stop:
        main(["verify", str(file), "--mbar", "0.1", "--samples", "10", "--json", *given])
    content = json.loads(capsys.readouterr().out)
    assert stop.value.code in (0, 1)
    assert content["arm"] == "mine"
    assert [proviso["kind"] for proviso in content["provisos"]] == ["expanded xacro"]
    (tmp_path / "e.toml").write_text(
        f'arm = {{ source = "{file}", xacro = {{ height = 0.2, name = "mine" }}, '
        'package = { my_arm = "p/my_arm" } }\n'
        'name = "e"\nperiod = 0.001\nduration = 0.01\n'
        'reference = { kind = "quintic", start = [0, 0], targets = [[0, 0]], times = [0.01], move = 0.01 }\n'
        '[controllers.a]\nlaw = "ppc"\nmbar = 0.1\nks = 1.0\nbeta = 1.0\n'
    )
    assert load_experiment(tmp_path / "e.toml").build_arm().name == "mine"


@pytest.mark.parametrize("name", ["ver00", "xmlns_default", "xmlns_undef"])
def test_what_pinocchio_reads_is_read_the_same(name: str, tmp_path: Path) -> None:
    path = CASES / "urdf" / f"{name}.urdf"
    arm, theirs = load_arm(path), pin.buildModelFromUrdf(str(path))
    q = np.array([0.2, -0.4, 0.6])
    np.testing.assert_allclose(arm.mass_matrix(q), pin.crba(theirs, theirs.createData(), q), rtol=1e-13)
    assert arm.sha256 == hashlib.sha256(path.read_bytes()).hexdigest()
    # And the checker, which has a reader of its own, reads the same arm from what goes along.
    assert check(certify(load_arm(path, armature=50.0), 50.0, budget=30.0, gap=0.9).save(tmp_path / "c.cert")).valid


@pytest.mark.parametrize(
    "robot",
    [
        '<robot name="r" xmlns="http://www.ros.org">',
        '<?xml version="0.0"?><robot name="r">',
        '<?xml version="1.1"?><robot name="r">',
        '<robot name="r" drake:ignore="1"><drake:joint name="j"/>',
    ],
)
def test_such_a_file_keeps_its_visuals(robot: str, tmp_path: Path) -> None:
    arm = load_arm(write(tmp_path, BARE.replace('<robot name="r">', robot)))
    shown, problems = read_visuals(arm.urdf_text, arm.files)
    assert list(shown) == ["base"]
    assert not problems
    same_dynamics(arm.model, load_arm(write(tmp_path, BARE, "plain.urdf")).model)


@pytest.mark.parametrize("encoding", ["gbk", "big5", "shift_jis", "euc_kr", "utf-32", "utf-7", "hz", "rot13", "none"])
def test_an_encoding_that_is_not_read_is_refused_with_one_message(encoding: str, tmp_path: Path) -> None:
    text = f'<?xml version="1.0" encoding="{encoding}"?>{BARE}'
    path = tmp_path / "arm.urdf"
    path.write_bytes(text.encode("utf-32") if encoding == "utf-32" else text.encode())
    with pytest.raises(ArmError, match=r"which is not read here. Save the file as UTF-8"):
        load_arm(path)


def mesh_file(path: Path) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("solid\nendsolid\n")
    return path


def test_meshes_are_found_by_package_search_path_and_suffix(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path / "here" / "urdf"
    folder.mkdir(parents=True)
    name = "package://some_arm/meshes/a/link.stl"
    monkeypatch.delenv("ROS_PACKAGE_PATH", raising=False)
    monkeypatch.delenv("AMENT_PREFIX_PATH", raising=False)
    with pytest.raises(FileNotFoundError, match=r"say where the package lies: --package some_arm=DIR"):
        RobotFiles(folder).mesh(name)
    # From the last place that is looked at to the first; each wins over those before.
    beside = mesh_file(tmp_path / "here" / "a" / "link.stl")
    assert RobotFiles(folder).mesh(name) == beside
    ros = tmp_path / "ros1" / "src" / "stack" / "other_name"
    found = mesh_file(ros / "meshes" / "a" / "link.stl")
    (ros / "package.xml").write_text("<package><name>some_arm</name></package>")
    monkeypatch.setenv("ROS_PACKAGE_PATH", f"{tmp_path / 'nowhere'}:{tmp_path / 'ros1'}")
    assert RobotFiles(folder).mesh(name) == found
    ament = mesh_file(tmp_path / "ament" / "share" / "some_arm" / "meshes" / "a" / "link.stl")
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path / "ament"))
    assert RobotFiles(folder).mesh(name) == ament
    above = mesh_file(tmp_path / "some_arm" / "meshes" / "a" / "link.stl")
    assert RobotFiles(folder).mesh(name) == above
    given = mesh_file(tmp_path / "given" / "meshes" / "a" / "link.stl")
    assert RobotFiles(folder, {"some_arm": tmp_path / "given"}).mesh(name) == given
    # Somebody's absolute path, of whose end there is a copy beside the file.
    assert RobotFiles(folder).mesh("file:///home/somebody/ws/a/link.stl") == beside


@pytest.fixture
def descriptions(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A package robot_descriptions that has two robots, and one that the network does not give."""
    package = tmp_path / "site" / "robot_descriptions"
    package.mkdir(parents=True)
    (package / "__init__.py").write_text("")
    urdf = write(tmp_path, two_joints())
    xacro = xacro_package(tmp_path / "cloned")
    (package / "plain_description.py").write_text(f"URDF_PATH = {str(urdf)!r}")
    arguments = {"name": "mine", "height": "0.3"}
    (package / "template_description.py").write_text(f"XACRO_PATH = {str(xacro)!r}\nXACRO_ARGS = {arguments!r}")
    (package / "lost_description.py").write_text("raise OSError('no network')")
    (package / "muscles_description.py").write_text("SRDF_PATH = 'x'")
    monkeypatch.syspath_prepend(str(package.parent))
    for name in [name for name in sys.modules if name.partition(".")[0] == "robot_descriptions"]:
        monkeypatch.delitem(sys.modules, name)
    yield package
    for name in [name for name in sys.modules if name.partition(".")[0] == "robot_descriptions"]:
        del sys.modules[name]


def test_a_robot_is_known_by_its_name_in_robot_descriptions(descriptions: Path, tmp_path: Path) -> None:
    arm = load_arm("plain_description")
    same_dynamics(arm.model, load_arm(tmp_path / "arm.urdf").model)
    assert arm.name == "plain_description"
    template = load_arm("template_description", xacro={"height": "0.5"})
    assert "name=mine, height=0.5" in template.provisos[0].text
    with pytest.raises(ArmError, match="could not fetch it: no network"):
        load_arm("lost_description")
    with pytest.raises(ArmError, match="has no URDF of it"):
        load_arm("muscles_description")
    with pytest.raises(ArmError, match="which is installed, has none of that name either"):
        load_arm("absent_description")


def test_without_that_package_the_message_names_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(named_descriptions, "find_spec", lambda name: None)
    with pytest.raises(ArmError, match="pip install robot_descriptions"):
        load_arm("ur5e_description")


def test_looking_at_a_result_runs_no_xacro_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = xacro_package(tmp_path / "p")
    (tmp_path / "e.toml").write_text(
        f'name = "e"\nperiod = 0.002\nduration = 0.02\narm = {{ source = "{file}", xacro = {{ name = "r" }}, '
        "armature = 0.1, payload = 0.5 }\n"
        'reference = { kind = "quintic", start = [0.0, 0.5], targets = [[0.0, 0.5]], times = [0.02], move = 0.02 }\n'
        '[controllers.a]\nlaw = "ppc"\nmbar = 0.1\nks = 1.0\nbeta = 1.0\n'
    )
    experiment = load_experiment(tmp_path / "e.toml")
    compare(experiment, tmp_path / "out")
    ran = experiment.build_arm()

    def run(*_: object) -> None:
        raise AssertionError("expanded")

    monkeypatch.setattr(urdf_document, "expand", run)
    file.unlink()
    shown = load_result(tmp_path / "out").experiment.build_arm()
    q = np.array([0.3, -0.4])
    assert np.array_equal(shown.mass_matrix(q), ran.mass_matrix(q))
    for part in ("name", "sha256", "provisos", "urdf_text"):
        assert getattr(shown, part) == getattr(ran, part)
    # Without that URDF there is no arm to show, and still nothing is run.
    stranger = load_experiment(tmp_path / "e.toml", import_laws=False)
    file.write_text(f'<robot name="r" {XMLNS}><xacro:include filename="x"/></robot>')
    with pytest.raises(ArmError, match="a xacro file is a program, and where somebody else's file may name it, none"):
        stranger.build_arm()
