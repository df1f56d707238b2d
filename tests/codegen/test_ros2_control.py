"""The ros2_control plugin compiles against stand-ins with documented signatures, and commands what the C commands."""

from __future__ import annotations

import subprocess
import xml.etree.ElementTree as ElementTree
from pathlib import Path

from export_cases import KINDS, exported
from needs import program

STUBS = Path(__file__).parent / "ros2_stubs"
FORBIDDEN = ("new ", "malloc", "push_back", "emplace_back", "RCLCPP_", "throw", "mutex", "lock", "std::string", "cout")
"""What a real-time update does not do."""


def test_the_plugin_commands_what_the_c_alone_commands_and_reports_a_fault(tmp_path):
    folder = tmp_path / "x"
    exported(folder, KINDS["baek2016"], target="ros2_control")
    strict = ["-Wall", "-Wextra", "-Wconversion", "-pedantic", "-Werror", "-ffp-contract=off"]
    subprocess.run([program("c"), "-std=c99", *strict, "-c", "short_it.c"], cwd=folder, check=True)
    sources = ["short_it_controller.cpp", str(STUBS / "drive.cpp"), "short_it.o"]
    command = [program("c++"), "-std=c++17", *strict, f"-I{STUBS}", "-I.", *sources, "-o", "drive", "-lm"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    said = subprocess.run(["./drive"], cwd=folder, capture_output=True, text=True, check=True).stdout.splitlines()
    joints = ("joint_1", "joint_2")
    assert [line for line in said if line.startswith("command")] == [f"command {joint}/effort" for joint in joints]
    kinds = ("position", "velocity", "effort")
    assert [line for line in said if line.startswith("state")] == [
        f"state {j}/{kind}" for kind in kinds for j in joints
    ]
    assert "reference stub/joint_2/acceleration" in said
    assert "unequal 0" in said
    errors = int(said[-1].split()[1])
    assert 60 < errors < 100  # from the end of the ramp on


def test_its_update_keeps_the_rules_of_real_time(tmp_path):
    exported(tmp_path / "x", KINDS["ppc"], target="ros2_control")
    source = (tmp_path / "x" / "short_it_controller.cpp").read_text()
    update = source.split("return_type Controller::update_and_write_commands")[1].split("\n}\n")[0]
    read = source.split("void Controller::read")[1].split("\n}\n")[0]
    assert not [word for word in FORBIDDEN if word in update + read]


def test_its_description_names_the_class_and_its_readme_says_what_was_not_tested(tmp_path):
    folder = tmp_path / "x"
    exported(folder, KINDS["ppc"], target="ros2_control")
    described = ElementTree.parse(folder / "short_it_plugin.xml").getroot()
    assert described.attrib["path"] == "short_it_controller"
    assert described[0].attrib["type"] == "short_it::Controller"
    assert ElementTree.parse(folder / "package.xml").getroot().findtext("name") == "short_it_controller"
    assert "${PROJECT_NAME}" in (folder / "CMakeLists.txt").read_text()
    assert "update_rate: 1000 " in (folder / "short_it_controllers.yaml").read_text()
    assert "not against ROS, and on no robot" in " ".join((folder / "README.md").read_text().split())
