"""Claims about the last line of a verdict: the command that follows from it, about the same arm and ranges."""

import json

import numpy as np
import pytest
import typer
from arm_urdf import inertial, two_joints
from next_command import next_words
from short_experiment import SHORT

from asmc_pin import lemma1_norm, load_arm, load_experiment, verify, weighted_norm
from asmc_pin.cli.dispatch import app
from asmc_pin.cli.entry import main
from asmc_pin.condition.search.what_would_help import joint_to_blame


def run(capsys, *words):
    """Exit status and standard output of a command."""
    with pytest.raises(SystemExit) as ended:
        main(words)
    return ended.value.code, capsys.readouterr().out


def parsed(words):
    """The parameters that the command line makes of a command, which is not run."""
    group = typer.main.get_command(app)
    command = group.get_command(None, words[0])
    return command.make_context(words[0], list(words[1:])).params


def test_after_a_violation_the_next_command_finds_an_mbar_for_the_same_arm_that_is_not_violated(capsys):
    status, out = run(capsys, "verify", "two_link", "--mbar", "9", "--payload", "1.5", "--box", "joint_2=-1:1")
    assert status == 1
    words = next_words(out)
    assert words[:2] == ["design", "two_link"]
    assert sorted(words[2:]) == sorted(["--box", "joint_2=-1:1", "--payload", "1.5"])
    status, out = run(capsys, *words, "--json")
    assert status == 0
    assert json.loads(out)["payload"]["mass"] == 1.5


GOOD = np.array([0.14779, 0.16718, 0.15018, 0.08178, 0.0941, 0.01704])
"""An M̄ that a search on the UR5 does not refute, kg·m²."""


def test_the_joint_to_blame_is_the_one_whose_mbar_was_made_too_large():
    arm = load_arm("ur5")
    assert verify(arm, GOOD, samples=4096).remedy is None
    for condition in ("lemma1", "weighted"):
        for joint, name in enumerate(arm.joint_names):
            wrong = GOOD.copy()
            wrong[joint] *= 100.0
            remedy = verify(arm, wrong, condition=condition, samples=4096).remedy
            assert (remedy.joint, remedy.side) == (name, "large")


@pytest.mark.parametrize(("condition", "norm"), [("lemma1", lemma1_norm), ("weighted", weighted_norm)])
def test_the_joint_to_blame_is_where_the_norm_depends_on_mbar_most(condition, norm):
    arm = load_arm("ur5")
    rng = np.random.default_rng(0)
    for q in rng.uniform(-3.0, 3.0, (20, 6)):
        mass, mbar = arm.mass_matrix(q), GOOD * np.exp(rng.normal(size=6))
        step = 1e-6 * np.diag(mbar)
        slope = np.array([norm(mass, mbar + one) - norm(mass, mbar - one) for one in step])
        joint, side = joint_to_blame(condition, mass, mbar)
        assert joint == np.argmax(np.abs(slope))
        assert side == ("large" if slope[joint] > 0.0 else "small")


@pytest.mark.parametrize("condition", ["lemma1", "weighted"])
def test_the_multiple_that_a_violation_names_holds_and_a_larger_one_does_not(condition):
    arm = load_arm("two_link")
    remedy = verify(arm, [1.0, 0.8], condition=condition).remedy
    assert 0.0 < remedy.scale < 1.0
    for factor, verdict in ((0.99, "unrefuted"), (1.01, "violated")):
        mbar = factor * remedy.scale * np.array([1.0, 0.8])
        assert verify(arm, mbar, condition=condition).verdict == verdict


def test_joints_that_do_not_suit_each_other_are_said_to_bear_no_multiple():
    arm = load_arm("ur5")
    remedy = verify(arm, [1.0, 1e-6, 1.0, 1e-6, 1.0, 1.0], samples=4096).remedy
    assert remedy.scale == 0.0
    assert "no multiple" in remedy.lines()[1]


def test_after_a_search_that_refutes_nothing_the_next_command_proves_the_same_statement(capsys):
    status, out = run(capsys, "verify", "two_link", "--mbar", "0.02")
    assert status == 0
    status, out = run(capsys, *next_words(out))
    assert status == 0
    assert "holds" in out
    assert next_words(out)[:1] == ["design"]


def test_a_design_whose_time_was_up_is_told_the_same_command_with_twice_the_time(capsys):
    asked = ("--payload", "1", "--objective", "bandwidth")
    status, out = run(capsys, "design", "two_link", *asked, "--budget", "1e-3")
    assert status == 0
    *_, more, last = out.splitlines()
    assert last.startswith("next: gains for it")
    twice = parsed(next_words(more))
    assert (twice["payload"], twice["objective"], twice["budget"]) == ("1", "bandwidth", 2e-3)
    _, out = run(capsys, "design", "two_link")
    assert "twice the time" not in out


def test_json_carries_no_such_line(capsys):
    _, out = run(capsys, "verify", "two_link", "--mbar", "9", "--json")
    assert json.loads(out)["verdict"] == "violated"


SHORT_LOOP = ("--mbar", "0.02", "--ks", "5", "--beta", "5")


@pytest.mark.parametrize(
    ("words", "verb"),
    [
        (("verify", "two_link", "--mbar", "0.02", "--along", "baek2016_simulation_smooth"), "verify"),
        (("design", "two_link"), "design"),
        (("design", "two_link", "--bounds", "joint_1=50:60"), "bounds"),
        (("bounds", "two_link", "--gap", "0.2"), "design"),
        (("agree", "two_link"), "design"),
        (("inspect", "two_link"), "design"),
        (("stability", "two_link", *SHORT_LOOP, "--period", "0.001"), "stability"),
        (("stability", "two_link", "--mbar", "0.5", "--ks", "5", "--beta", "5", "--period", "0.1"), "design"),
    ],
)
def test_every_verdict_ends_with_a_command_about_the_same_arm_that_is_taken(capsys, words, verb):
    _, out = run(capsys, *words)
    following = next_words(out)
    assert following[:2] == [verb, "two_link"]
    assert parsed(following)["arm"] == "two_link"


def test_what_follows_a_proof_along_a_motion_is_a_proof_within_a_tube_around_it(capsys):
    _, out = run(capsys, "verify", "two_link", "--mbar", "0.02", "--along", "baek2016_simulation_smooth")
    options = parsed(next_words(out))
    assert (options["along"], options["tube"], options["certify"]) == ("baek2016_simulation_smooth", 0.05, True)


def test_a_comparison_ends_with_the_proof_of_its_mbar_on_the_arm_with_its_load_and_rotors(capsys, tmp_path):
    file = tmp_path / "short.toml"
    file.write_text(SHORT.replace('arm = "two_link"', 'arm = { source = "two_link", payload = 0.5, armature = 0.01 }'))
    status, out = run(capsys, "compare", str(file), "--out", str(tmp_path / "out"))
    assert status == 0
    options = parsed(next_words(out))
    experiment = load_experiment(str(file))
    given = (options["arm"], float(options["payload"]), options["armature"], options["certify"])
    assert given == ("two_link", 0.5, "0.01,0.01", True)
    np.testing.assert_allclose(float(options["mbar"]), experiment.defaults["mbar"])


def test_a_certificate_that_holds_leads_on_to_what_it_takes_for_granted(capsys, tmp_path):
    proof = str(tmp_path / "two_link.cert")
    run(capsys, "verify", "two_link", "--mbar", "0.02", "--certify", "--certificate", proof)
    _, out = run(capsys, "check", proof)
    assert next_words(out) == ["agree", "two_link"]


def test_a_certificate_of_a_file_of_ones_own_leads_to_that_file_where_it_lies_here(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.urdf").write_text(two_joints())
    run(capsys, "verify", "mine.urdf", "--mbar", "0.02", "--certify", "--certificate", "mine.cert")
    assert next_words(run(capsys, "check", "mine.cert")[1]) == ["agree", "mine.urdf"]
    (tmp_path / "mine.urdf").rename("other.urdf")
    _, out = run(capsys, "check", "mine.cert")
    assert next_words(out) == ["agree", "other.urdf"]
    (tmp_path / "other.urdf").unlink()
    _, out = run(capsys, "check", "mine.cert")
    assert out.splitlines()[-1].endswith(" (ARM: the URDF of r): asmc-pin agree ARM")


def test_what_follows_a_refused_urdf_is_its_repair_where_there_is_one_and_then_its_mbar(capsys, tmp_path):
    file = tmp_path / "thin.urdf"
    file.write_text(two_joints(tip=inertial(inertia=np.diag([-0.01, 0.02, 0.015]))))
    status, out = run(capsys, "inspect", str(file))
    assert status == 1
    assert next_words(out) == ["inspect", str(file), "--repair"]
    status, out = run(capsys, *next_words(out))
    assert status == 0
    assert next_words(out) == ["design", str(file), "--repair"]


def test_what_follows_doubts_is_a_picture_of_what_is_doubted(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "wide.urdf").write_text(two_joints(tip=inertial(inertia=np.diag([5.0, 5.0, 5.0]))))
    _, out = run(capsys, "inspect", "wide.urdf")
    assert next_words(out) == ["inspect", "wide.urdf", "--html", "wide.html"]
    _, out = run(capsys, *next_words(out))
    assert next_words(out)[0] == "design"
    assert (tmp_path / "wide.html").is_file()


def test_a_result_that_is_not_there_is_made_by_the_command_that_the_message_names(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit) as ended:
        main(["view", "demo"])
    assert ended.value.code == 2
    assert "make it with: asmc-pin compare demo" in capsys.readouterr().err
    for name, meant in (
        ("rows.parquet", "--replay TRIAL"),
        ("tuned.toml", "asmc-pin compare demo/tuned.toml"),
        ("bench.json", "read demo/report.html"),
    ):
        (tmp_path / "demo").mkdir(exist_ok=True)
        (tmp_path / "demo" / name).touch()
        with pytest.raises(SystemExit):
            main(["report", "demo"])
        assert meant in capsys.readouterr().err
        (tmp_path / "demo" / name).unlink()


def test_a_result_whose_name_is_nearly_right_is_answered_with_the_one_that_is_there(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "results" / "second").mkdir(parents=True)
    (tmp_path / "results" / "second" / "experiment.toml").touch()
    for given, meant in (("secnd", "did you mean results/second?"), ("DEMO", "did you mean demo?")):
        for verb in ("view", "report"):
            with pytest.raises(SystemExit) as ended:
                main([verb, given])
            assert ended.value.code == 2
            assert meant in capsys.readouterr().err
    (tmp_path / "page.html").touch()
    with pytest.raises(SystemExit):
        main(["view", "page.html"])
    assert "page.html is a file, and a result is a folder" in capsys.readouterr().err
