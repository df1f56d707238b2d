"""The hypotheses stand beside every verdict: armature, payload, locked joints, box and condition are never left out."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from arm_urdf import LIMIT, inertial, joint, link, robot, write
from short_experiment import SHORT
from test_layering import imports_of

from asmc_pin import load_arm, verify
from asmc_pin.arms import Arm, Payload
from asmc_pin.cli import main
from asmc_pin.condition import Recording, certified, design
from asmc_pin.condition.certificate import certify
from asmc_pin.condition.checker import check
from asmc_pin.condition.hypotheses import Hypotheses, fold_locks, formula
from asmc_pin.condition.norm.two_conditions import Condition
from asmc_pin.errors import ParameterError
from asmc_pin.pages.comparison_page import report_text
from asmc_pin.pages.condition_page import write_condition_report
from asmc_pin.results.result_folder import load_result
from asmc_pin.sampled import stability

Run = Callable[..., tuple[int, str, str]]

# What is asked for on the command line, and how text, page and JSON must name it.
HYPOTHESES = {
    "armature": (["--armature", "5"], "armature 5 kg·m² at every joint", {"armature": [5.0, 5.0]}),
    "armature range": (["--armature", "1:5,2"], "armature (1 to 5, 2) kg·m²", {"armature": [[1.0, 5.0], 2.0]}),
    "payload": (
        ["--payload", "2"],
        "payload 2 kg",
        {"payload": {"mass": 2.0, "link": "link_2", "com": [0.0, 0.0, 0.0]}},
    ),
    "payload range": (
        ["--payload", "0:2"],
        "payload 0 to 2 kg",
        {"payload": {"mass": [0.0, 2.0], "link": "link_2", "com": [0.0, 0.0, 0.0]}},
    ),
    "lock": (["--lock", "joint_2=0.5"], "joint_2 at 0.5 locked", {"locked": {"joint_2": 0.5}}),
    "lock choices": (
        ["--lock", "joint_2=0.5,1"],
        "joint_2 at 0.5 and at 1 locked",
        {"locked": {"joint_2": [0.5, 1.0]}},
    ),
}
BARE = {"armature": [0.0, 0.0], "payload": None, "locked": {}}


@pytest.fixture
def asmc_pin(capfd: pytest.CaptureFixture[str]) -> Run:
    """Run the command line in this process: status, standard output, standard error."""

    def run(*arguments: str) -> tuple[int, str, str]:
        with pytest.raises(SystemExit) as end:
            main(list(arguments))
        out, err = capfd.readouterr()
        assert isinstance(end.value.code, int)
        return end.value.code, out, err

    return run


@pytest.fixture(scope="module")
def two_link() -> Arm:
    return load_arm("two_link")


@pytest.mark.parametrize("name", HYPOTHESES)
@pytest.mark.parametrize("command", ["verify", "design"])
def test_each_hypothesis_is_in_text_json_and_page(asmc_pin: Run, tmp_path: Path, command: str, name: str) -> None:
    options, said, keys = HYPOTHESES[name]
    asked = (
        ["verify", "two_link", "--mbar", "0.01", "--samples", "64"] if command == "verify" else [command, "two_link"]
    )
    status, text, err = asmc_pin(*asked, *options, "--report", str(tmp_path / "page.html"))
    assert status == 0, err
    assert f"two_link with {said}" in text
    page = (tmp_path / "page.html").read_text(encoding="utf-8")
    heading = f"Lemma 1 on two_link with {said}: unrefuted"
    assert f"<h1>{heading}</h1>" in page
    assert f"<title>{heading}</title>" in page
    assert f"On two_link with {said}, no configuration" in page
    status, out, _ = asmc_pin(*asked, *options, "--json")
    content = json.loads(out)
    moving = ["joint_1"] if "locked" in keys else ["joint_1", "joint_2"]
    expected = {**BARE, "armature": [0.0] * len(moving), **keys}
    assert {key: content[key] for key in expected} == expected
    assert list(content["box"]) == content["joints"] == moving
    assert content["scope"] == "box"


def test_the_bare_arm_is_said_to_be_bare(asmc_pin: Run) -> None:
    _, text, _ = asmc_pin("verify", "two_link", "--mbar", "0.01", "--samples", "64")
    assert "two_link: unrefuted" in text
    for line in ("Armature: none", "Payload: none", "Locked joints: none", "Condition: Lemma 1: ‖I − M⁻¹M̄‖₂ < 1"):
        assert line in text.splitlines()


def test_a_narrower_box_is_in_text_json_and_page(asmc_pin: Run, tmp_path: Path) -> None:
    asked = ["verify", "two_link", "--mbar", "0.01", "--samples", "64", "--box", "joint_2=-0.25:0.5"]
    _, text, _ = asmc_pin(*asked, "--report", str(tmp_path / "page.md"))
    assert "joint_2 -0.25:0.5 rad" in text
    assert "joint_2 -0.25:0.5 rad" in (tmp_path / "page.md").read_text(encoding="utf-8")
    assert json.loads(asmc_pin(*asked, "--json")[1])["box"]["joint_2"] == [-0.25, 0.5]


def test_a_range_that_is_taken_as_one_turn_is_said_to_be(asmc_pin: Run) -> None:
    told = "Whole turns: {}: a range of a turn or more is taken as one turn, which loses nothing: M(q) repeats after 2π"
    _, text, _ = asmc_pin("design", "two_link", "--box", "joint_2=-4:4")
    assert told.format("every joint") in text.splitlines()
    asked = ["verify", "two_link", "--mbar", "0.01", "--samples", "64"]
    _, text, _ = asmc_pin(*asked, "--box", "joint_2=-1:1")
    assert told.format("joint_1") in text.splitlines()
    _, text, _ = asmc_pin(*asked, "--box", "joint_2=-1:1", "--box", "joint_1=-3:3.2")
    assert "Whole turns" not in text
    q = np.random.default_rng(0).uniform(-np.pi, np.pi, (20, 6))
    arm = load_arm("ur5")
    np.testing.assert_allclose(arm.mass_matrix(q + 2.0 * np.pi), arm.mass_matrix(q), atol=1e-12)


def test_a_long_slide_is_no_whole_turn(tmp_path: Path) -> None:
    text = robot(link("base"), link("cart", inertial(2.0)), joint("rail", "base", "cart", kind="prismatic"))
    arm = load_arm(write(tmp_path, text))
    assert verify(arm, 1.0, box={"rail": (-10.0, 10.0)}, samples=8).hypotheses.turning == ()


def test_where_no_mbar_suits_the_hypotheses_are_named_all_the_same(asmc_pin: Run, tmp_path: Path) -> None:
    asked = ["design", "two_link", "--payload", "0:2", "--bounds", "joint_1=50:60", "--condition", "weighted"]
    status, text, _ = asmc_pin(*asked, "--report", str(tmp_path / "page.html"))
    assert status == 1
    assert "two_link with payload 0 to 2 kg: no M̄ within the bounds" in text
    assert "joint_1 50:60" in text
    assert "Lemma 1" not in text
    page = (tmp_path / "page.html").read_text(encoding="utf-8")
    assert "two_link with payload 0 to 2 kg: infeasible" in page
    assert "joint_1 50:60" in page
    content = json.loads(asmc_pin(*asked, "--json")[1])
    assert (content["mbar"], content["worst_q"], content["worst_armature"]) == (None, None, None)
    assert content["payload"]["mass"] == [0.0, 2.0]
    assert content["bounds"] == {"joint_1": [50.0, 60.0], "joint_2": [0.0, None]}
    assert content["box"]["joint_2"] == pytest.approx([-np.pi, np.pi])


def test_the_worst_configuration_names_the_arm_that_it_belongs_to(two_link: Arm) -> None:
    report = verify(two_link, 0.01, payload=(0.0, 2.0), armature=[(0.1, 0.3), 0.2], samples=64)
    content = report.to_json_dict()
    held = two_link.replace(payload=content["worst_payload"]["mass"], armature=content["worst_armature"])
    norm = verify(held, 0.01, box={name: (q, q) for name, q in zip(held.joint_names, report.worst_q, strict=True)})
    assert norm.lower == pytest.approx(report.lower, rel=1e-9)
    assert "worst_locked" not in content
    choice = verify(two_link, 0.01, lock={"joint_2": [0.1 + 0.2, 3.0]}, samples=64).to_json_dict()
    assert choice["worst_locked"]["joint_2"] in (0.1 + 0.2, 3.0)
    assert choice["worst_case"]


def test_the_light_end_of_a_payload_range_may_be_nothing(two_link: Arm) -> None:
    body = Payload(1.0, com=(0.0, 0.0, 0.1), inertia=(0.01, 0.0, 0.0, 0.01, 0.0, 0.01))
    report = verify(two_link, 0.01, payload=(None, body), samples=64)
    assert report.hypotheses.payload is not None
    assert report.hypotheses.payload.to_json_dict() == {
        "mass": [0.0, 1.0],
        "link": "link_2",
        "com": [0.0, 0.0, 0.1],
        "inertia": [0.01, 0.0, 0.0, 0.01, 0.0, 0.01],
        "inertia_lightest": [0.0] * 6,
    }
    assert "inertia about its centre" in report.hypotheses.payload.words()
    # An M̄ that the light arm bears least: the worst is without the payload.
    light = verify(two_link, 0.2, payload=(None, body), samples=64).to_json_dict()
    assert light["worst_payload"]["mass"] == 0.0
    assert verify(two_link, 0.2, payload=0.0, samples=64).hypotheses.payload is None


def test_a_level_is_part_of_the_condition() -> None:
    assert formula("lemma1", 0.5) == "‖I − M⁻¹M̄‖₂ < 0.5"
    # M̄ ≺ 2M is the weighted condition and not its level.
    assert formula("weighted", 0.5) == "max|1 − λ(M⁻¹M̄)| < 0.5"
    assert formula("weighted") == "max|1 − λ(M⁻¹M̄)| < 1, i.e. M̄ ≺ 2M"


def test_locked_joints_that_move_together_are_not_said_to_be_combined() -> None:
    every = [{"a": 0.0, "b": x, "c": y} for x in (1.0, 2.0) for y in (3.0, 4.0)]
    assert fold_locks(every) == ({"a": 0.0, "b": (1.0, 2.0), "c": (3.0, 4.0)}, False)
    pairs = [{"a": 0.0, "b": x, "c": 2.0 * x} for x in (1.0, 2.0)]
    assert fold_locks(pairs) == ({"a": 0.0, "b": (1.0, 2.0), "c": (2.0, 4.0)}, True)
    assert fold_locks([{}]) == ({}, False)


def test_a_follower_of_a_locked_joint_is_locked_together_with_it(tmp_path: Path) -> None:
    follows = joint("follower", "hand", "finger", extra=LIMIT + '<mimic joint="master" multiplier="2"/>')
    text = robot(
        *(link(name, inertial()) for name in ("base", "arm", "hand", "finger")),
        *(joint("first", "base", "arm", axis="0 1 0"), joint("master", "arm", "hand", axis="1 0 0"), follows),
    )
    arm = load_arm(write(tmp_path, text), lock={"master": 0.0})
    content = verify(arm, 0.01, lock={"master": [0.0, 0.5]}, samples=16).to_json_dict()
    assert content["locked"] == {"master": [0.0, 0.5], "follower": [0.0, 1.0]}
    assert content["locked_together"] is True
    # A certificate says the same, and the checker derives it.
    proof = certify(arm, 0.01, lock={"master": [0.0, 0.5]}, budget=5.0, levels=False).save(tmp_path / "proof.cert")
    told = check(proof).to_json_dict()
    assert told["valid"]
    assert {key: told[key] for key in ("locked", "locked_together")} == {
        key: content[key] for key in ("locked", "locked_together")
    }


def test_names_pass_no_control_characters(tmp_path: Path) -> None:
    # The loader refuses such names; who makes hypotheses of a stranger's file may meet them all the same.
    evil = "a\x1b[2Jb\nc\x9b2J"
    text = robot(link("base"), link("arm", inertial()), joint("j", "base", "arm"))
    about = verify(load_arm(write(tmp_path, text)), 0.001, samples=16).hypotheses
    about = replace(about, arm=evil, joints=(evil,), locked={evil: 0.0}, box={evil: about.box["j"]})
    said = json.dumps(about.to_json_dict(), ensure_ascii=False) + "".join(about.lines()) + about.title
    assert "x1b[2Jb" in said
    assert not {"\x1b", "\x9b", "\n"} & set(said)


# One change each: what a search and a proof may not differ in.
OTHERS = {
    "armature": {"armature": 0.02},
    "armature range": {"armature": (0.01, 0.02)},
    "payload": {"payload": 0.5},
    "payload range": {"payload": (0.0, 0.5)},
    "box": {"box": {"joint_2": (-1.0, 1.0)}},
    "condition": {"condition": "weighted"},
}


@pytest.mark.parametrize("name", OTHERS)
def test_a_proof_of_another_statement_is_not_joined_with_a_search(two_link: Arm, name: str) -> None:
    found = verify(two_link, 0.01, armature=0.01, samples=64)
    assert certified(found, certify(two_link, 0.01, armature=0.01, budget=10.0, levels=False)).kind == "certified"
    other = certify(two_link, 0.01, budget=10.0, levels=False, **{"armature": 0.01, **OTHERS[name]})  # type: ignore[arg-type]
    with pytest.raises(ParameterError, match="not of the same"):
        certified(found, other)
    level = certify(two_link, 0.01, armature=0.01, budget=10.0, level=0.999)
    with pytest.raises(ParameterError, match="differ in level"):
        certified(found, level)


def test_a_proof_at_another_locked_angle_is_not_joined_with_a_search(two_link: Arm) -> None:
    found = verify(two_link, 0.01, lock={"joint_2": 0.5}, samples=64)
    proofs = [certify(two_link, 0.01, lock={"joint_2": angle}, levels=False) for angle in (0.5, 0.6)]
    assert certified(found, proofs[0]).hypotheses.locked == {"joint_2": 0.5}
    with pytest.raises(ParameterError, match="differ in locked"):
        certified(found, proofs[1])


def test_tubes_with_one_common_range_are_told_apart(two_link: Arm) -> None:
    time = np.linspace(0.0, 1.0, 21)
    there = np.stack((0.0 * time, np.sin(2.0 * np.pi * time)), axis=-1)
    found, same, other = (
        run(two_link, 0.01, along=Recording("log", time, q), tube_width=0.1, slices=4, **options)  # type: ignore[operator]
        for run, q, options in (
            (verify, there, {"samples": 64}),
            (certify, there, {"levels": False}),
            (certify, -there, {"levels": False}),
        )
    )
    assert certified(found, same).hypotheses.parts == 4
    assert "In 4 joint boxes along a motion" in "\n".join(found.hypotheses.lines())
    assert found.hypotheses.box == other.hypotheses.box
    with pytest.raises(ParameterError, match="differ in boxes"):
        certified(found, other)


def test_a_certified_verdict_keeps_its_hypotheses(asmc_pin: Run) -> None:
    asked = [
        "verify",
        "two_link",
        "--mbar",
        "0.01",
        "--armature",
        "5",
        "--samples",
        "64",
        "--certify",
        "--budget",
        "10",
    ]
    _, text, _ = asmc_pin(*asked)
    assert "two_link with armature 5 kg·m² at every joint: holds" in text
    content = json.loads(asmc_pin(*asked, "--json")[1])
    assert (content["kind"], content["armature"], content["worst_armature"]) == ("certified", [5.0, 5.0], [5.0, 5.0])
    assert content["scale_proven"] >= 1.0


@pytest.mark.parametrize("condition", ["lemma1", "weighted"])
def test_the_hypotheses_of_search_proof_and_design_are_one_object(two_link: Arm, condition: Condition) -> None:
    ranges = {"payload": (0.0, 1.0), "armature": (0.01, 0.02), "condition": condition}
    designed = design(two_link, explain=False, **ranges)  # type: ignore[arg-type]
    assert designed.mbar is not None
    searched = verify(two_link, designed.mbar, samples=64, **ranges)  # type: ignore[arg-type]
    proven = certify(two_link, designed.mbar, budget=0.5, levels=False, **ranges)  # type: ignore[arg-type]
    assert designed.hypotheses == searched.hypotheses == proven.hypotheses
    assert isinstance(searched.hypotheses, Hypotheses)
    assert searched.hypotheses != replace(searched.hypotheses, armature=(0.01, 0.02))


def test_stability_names_what_it_supposes(two_link: Arm) -> None:
    held = two_link.replace(payload=1.5, armature=0.1, gravity=(0.0, 0.0, 0.0))
    report = stability(held, 0.01, 20.0, 20.0, 0.001, samples=64, limits=False, box={"joint_2": (-1.0, 1.0)})
    text = "\n".join(report.lines())
    assert "two_link with armature 0.1 kg·m² at every joint, payload 1.5 kg: the sampled loop" in text
    assert "Gravity: (0, 0, 0) m/s²" in text
    assert "L = 0.001 s" in text
    content = report.to_json_dict()
    assert (content["armature"], content["payload"]["mass"], content["locked"]) == ([0.1, 0.1], 1.5, {})
    assert (content["box"]["joint_2"], content["gravity"]) == ([-1.0, 1.0], [0.0, 0.0, 0.0])


def test_a_comparison_names_the_arm_that_its_verdicts_are_about(
    asmc_pin: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    arm = '{ source = "two_link", payload = 1.5, armature = 0.25 }'
    (tmp_path / "short.toml").write_text(SHORT.replace('"two_link"', arm), encoding="utf-8")
    status, text, err = asmc_pin("compare", "short.toml")
    assert status == 0, err
    title = "two_link with armature 0.25 kg·m² at every joint, payload 1.5 kg"
    assert f"Lemma 1 along the reference on {title}, with M̄ = diag(" in text.replace("\n", " ")
    result = load_result(tmp_path / "results" / "short")
    for said in (
        (result.path / "summary.md").read_text(encoding="utf-8").splitlines()[2],
        report_text(result).partition("</p>")[0],
    ):
        assert title in said
    page = report_text(result)
    assert "<dt>Armature</dt><dd>0.25 kg·m² at every joint</dd>" in page
    assert "<dt>Payload</dt><dd>1.5 kg at (0, 0, 0) m on link_2</dd>" in page
    assert "payload 1.5 kg" in (result.path / "summary.tex").read_text(encoding="utf-8")
    _, out, _ = asmc_pin("compare", "short.toml", "--force", "--json")
    about = json.loads(out)["controllers"]["PPC"]["lemma1_hypotheses"]
    assert (about["armature"], about["payload"]["mass"], about["scope"]) == ([0.25, 0.25], 1.5, "motion")
    assert len(about["mbar"]) == 2


def test_the_page_of_a_range_names_all_of_it(two_link: Arm, tmp_path: Path) -> None:
    report = verify(two_link, 0.01, payload=(0.0, 2.0), lock={"joint_2": [0.0, 1.0]}, samples=64)
    write_condition_report(report, two_link, tmp_path / "page.md")
    text = (tmp_path / "page.md").read_text(encoding="utf-8")
    assert "**Payload**: 0 to 2 kg at (0, 0, 0) m on" in text
    assert "**Locked joints**: joint_2 at 0 and at 1" in text


def test_the_words_of_hypotheses_need_nothing_heavy() -> None:
    # The independent checker uses them, and shares nothing else with the prover.
    named = {name.partition(".")[0] for name in imports_of("asmc_pin.condition.hypotheses")}
    assert named - {"asmc_pin"} <= sys.stdlib_module_names
    named = imports_of("asmc_pin.condition.hypotheses")
    assert {name.rpartition(".")[0] for name in named if name.startswith("asmc_pin.")} <= {
        "asmc_pin.words.choices",
        "asmc_pin.words.joint_units",
        "asmc_pin.words.provisos",
        "asmc_pin.words.text",
    }
