"""A part of a robot: joints locked by pattern, one chain of several, grippers at once, in the interface's own words."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from arm_urdf import inertial, joint, link, two_arms, two_joints, write

from asmc_pin import check, load_arm, load_experiment, verify
from asmc_pin.cli import main
from asmc_pin.condition.certificate import certify
from asmc_pin.errors import ArmError, ExperimentError, ParameterError

LEFT = tuple(f"left{k}_joint" for k in range(1, 4))


@pytest.fixture
def torso(tmp_path: Path) -> Path:
    return write(tmp_path, two_arms(3, torso=True), "torso.urdf")


@pytest.fixture
def gripping(tmp_path: Path) -> Path:
    """Two joints, a hand with two fingers of which one mimics the other, and a knuckle beyond."""
    finger = inertial(0.05, "0 0 0.02", 1e-5 * np.eye(3))
    mimic = '<limit lower="0.01" upper="0.05" effort="1" velocity="1"/><mimic joint="slide_a"/>'
    parts = [
        link("hand", inertial(0.3)),
        link("finger_a", finger),
        link("finger_b", finger),
        link("knuckle", finger),
        joint("weld", "lower", "hand", "fixed"),
        joint("slide_a", "hand", "finger_a", "prismatic", extra=mimic.partition("<mimic")[0]),
        joint("slide_b", "hand", "finger_b", "prismatic", extra=mimic),
        joint("bend", "finger_a", "knuckle"),
    ]
    return write(tmp_path, two_joints().replace("</robot>", "".join(parts) + "</robot>"), "gripping.urdf")


def told(capsys: pytest.CaptureFixture[str], *arguments: str) -> tuple[int, str]:
    with pytest.raises(SystemExit) as stop:
        main(list(arguments))
    assert isinstance(stop.value.code, int)
    return stop.value.code, capsys.readouterr().err


def test_a_pattern_locks_all_that_it_matches(torso: Path) -> None:
    arm = load_arm(torso, lock={"right*": 0.5})
    assert arm.joint_names == ("waist", *LEFT)
    assert set(arm.locked.values()) == {0.5}


def test_an_exact_name_goes_before_a_pattern_wherever_it_stands(torso: Path) -> None:
    for lock in ({"right1_joint": 0.7, "right*": 0.5}, {"right*": 0.5, "right1_joint": 0.7}):
        assert load_arm(torso, lock=lock).locked["right1_joint"] == 0.7
    freed = load_arm(torso, lock={"right2_joint": "free", "right*": 0.5})
    assert "right2_joint" in freed.joint_names


def test_a_joint_whose_name_looks_like_a_pattern_is_meant_by_it(tmp_path: Path) -> None:
    text = two_joints().replace('"shoulder"', '"j[12]"').replace('"elbow"', '"j1"')
    arm = load_arm(write(tmp_path, text), lock={"j[12]": 0.2})
    assert dict(arm.locked) == {"j[12]": 0.2}


@pytest.mark.parametrize("pattern", ["links*", "weld*"])
def test_a_pattern_without_a_match_is_refused_and_the_joints_are_listed(pattern: str, gripping: Path) -> None:
    with pytest.raises(ParameterError, match=r"matches (no joint|fixed joints only).*shoulder, elbow, slide_a"):
        load_arm(gripping, lock={pattern: 0.0})


def test_a_chain_keeps_the_joints_between_two_links(torso: Path) -> None:
    assert load_arm(torso, chain=("torso", "left3")).joint_names == LEFT
    assert load_arm(torso, chain=("base", "left2")).joint_names == ("waist", *LEFT[:2])
    kept = load_arm(torso, chain=("torso", "left3"), lock={"waist": 0.3, "right1_joint": "free"})
    assert kept.locked["waist"] == 0.3
    assert kept.joint_names == (*LEFT, "right1_joint")


def test_what_is_off_the_chain_is_locked_within_its_limits(gripping: Path) -> None:
    arm = load_arm(gripping, chain=("base", "lower"))
    assert dict(arm.locked) == {"slide_a": 0.01, "slide_b": 0.01, "bend": 0.0}


def test_one_arm_of_two_moves_as_if_the_other_were_not_there(torso: Path) -> None:
    q = np.array([[0.3, -0.4, 0.8], [1.0, 0.2, -0.5]])
    alone = load_arm(torso, chain=("torso", "left3"))
    both = load_arm(torso, lock={"waist": 0.0})
    whole = both.mass_matrix(np.hstack([q, np.zeros((2, 3))]))
    assert alone.mass_matrix(q) == pytest.approx(whole[:, :3, :3], rel=1e-13)


@pytest.mark.parametrize(
    ("chain", "said"),
    [
        (("torso", "left9"), "no link 'left9'"),
        (("left1", "right3"), "'right3' does not hang on link 'left1'; .* right2, right1, torso, base"),
        (("left3", "torso"), r"'torso' carries link 'left3', not the other way round: chain=\('torso', 'left3'\)"),
        (("waist", "left3"), "'waist' is a joint; a chain is between two links: its own is 'torso'"),
        (("left3", "left3"), "no joint moves between"),
    ],
)
def test_a_chain_that_is_none_is_refused(chain: tuple[str, str], said: str, torso: Path) -> None:
    with pytest.raises(ParameterError, match=said):
        load_arm(torso, chain=chain)


def test_all_grippers_are_locked_in_one_go_each_within_its_range(gripping: Path) -> None:
    arm = load_arm(gripping, lock={"grippers": 0.0})
    assert arm.joint_names == ("shoulder", "elbow")
    assert dict(arm.locked) == {"slide_a": 0.01, "bend": 0.0, "slide_b": 0.01}
    assert load_arm(gripping, lock={"grippers": 0.0, "bend": 0.4}).locked["bend"] == 0.4


def test_an_arm_without_a_gripper_is_told_so(torso: Path) -> None:
    with pytest.raises(ParameterError, match="no joint looks like a gripper's"):
        load_arm(torso, lock={"grippers": 0.0})


def test_a_wrist_that_carries_fingers_is_no_gripper(gripping: Path) -> None:
    text = gripping.read_text().replace('"bend"', '"finger_bend"').replace('"lower"', '"finger_mount"')
    beyond = link("tool", inertial(0.2)) + joint("tool_turn", "knuckle", "tool")
    path = write(gripping.parent, text.replace("</robot>", beyond + "</robot>"), "beyond.urdf")
    assert "tool_turn" in load_arm(path, lock={"grippers": 0.0, "slide_a": 0.02}).joint_names


def test_a_certificate_of_a_chain_is_replayed(torso: Path, tmp_path: Path) -> None:
    arm = load_arm(torso, chain=("torso", "left2"))
    found = certify(arm, 0.02, condition="weighted", gap=0.3, budget=60.0, levels=False)
    assert check(found.save(tmp_path / "chain.cert")).valid


def test_a_note_on_two_arms_is_true_of_two_arms(tmp_path: Path) -> None:
    notes = verify(load_arm(write(tmp_path, two_arms(2))), 0.05, samples=20).notes
    (said,) = [note for note in notes if "does not depend" in note]
    assert "left1_joint, right1_joint: each hangs on the base and moves its branch as a whole" in said
    notes = verify(load_arm(write(tmp_path, two_joints())), 0.05, samples=20).notes
    assert any("shoulder, which carries the whole arm" in note for note in notes)


def test_messages_speak_as_the_interface_that_was_used(
    torso: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    many = write(tmp_path, two_arms(17))
    with pytest.raises(ArmError, match=r"chain=\('base', 'left17'\), or lock some, .* lock=\{'left_\*': 0.0\}"):
        load_arm(many)
    status, said = told(capsys, "verify", str(many), "--mbar", "0.1")
    assert status == 2
    assert "--chain base:left17, or lock some, by name or pattern as in --lock 'left_*=0'" in said
    experiment = load_experiment("demo").replace(arm={"source": str(many)})
    with pytest.raises(ArmError, match=r'arm\.chain = \["base", "left17"\].*arm\.lock = \{ "left_\*" = 0.0 \}'):
        experiment.build_arm()
    status, said = told(capsys, "verify", str(torso), "--mbar", "0.1", "--lock", "wais=0")
    assert said.startswith("asmc-pin: --lock: no joint 'wais'")
    experiment = load_experiment("demo").replace(arm={"source": str(torso), "lock": {"wais": 0.0}})
    with pytest.raises(ExperimentError, match=r"arm\.lock: no joint 'wais'"):
        experiment.build_arm()


def test_the_command_line_takes_patterns_chains_and_choices(torso: Path, capsys: pytest.CaptureFixture[str]) -> None:
    common = ("verify", str(torso), "--mbar", "0.05", "--samples", "20", "--json")
    with pytest.raises(SystemExit):
        main([*common, "--chain", "torso:left3"])
    assert '"left3_joint"' in capsys.readouterr().out
    with pytest.raises(SystemExit):
        main([*common, "--lock", "right*=0,0.5", "--lock", "waist=0"])
    out = capsys.readouterr().out
    assert '"right2_joint": [' in out
    status, said = told(capsys, *common, "--chain", "torso")
    assert status == 2
    assert "'torso' is not of the form BASE:TIP" in said


def test_an_experiment_takes_a_chain(torso: Path) -> None:
    experiment = load_experiment("demo").replace(arm={"source": str(torso), "chain": ["torso", "left3"]})
    assert experiment.build_arm().joint_names == LEFT


def test_a_headline_counts_the_joints_that_a_chain_locks_and_the_rows_name_them(torso: Path) -> None:
    about = verify(load_arm(torso, chain=("torso", "left3")), 0.05, samples=20).hypotheses
    assert "with 4 joints locked" not in about.title
    assert "right2_joint at 0" in about.title
    about = verify(load_arm(torso, chain=("torso", "left2")), 0.05, samples=20).hypotheses
    assert "with 5 joints locked" in about.title
    assert "left3_joint at 0" in dict(about.rows())["Locked joints"]
