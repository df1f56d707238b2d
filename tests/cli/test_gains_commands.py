"""`design --gains` and `stability` on the command line: one result, honest margins, ranges."""

import json
import math

import numpy as np
import pytest

from asmc_pin import load_arm
from asmc_pin.cli import main
from asmc_pin.sampled import SampledLoop
from asmc_pin.sampled.frozen_arms import frozen_arms
from asmc_pin.sampled.workspace_worst import workspace_of

LOOP = ["--ks", "6", "--beta", "20", "--period", "0.001"]


@pytest.fixture
def asmc_pin(capfd):
    """Run the command line in this process: status, standard output, standard error."""

    def run(*arguments):
        with pytest.raises(SystemExit) as end:
            main(list(arguments))
        out, err = capfd.readouterr()
        return end.value.code, out, err

    return run


def designed(asmc_pin, arm, *options):
    """The JSON of `design --gains`, and that its margins hold at other samples than the search had, at rest too."""
    status, out, err = asmc_pin("design", arm, *options, "--gains", "--period", "0.001", "--json")
    assert status == 0, err
    report = json.loads(out)
    gains = report["gains"]
    payload = (0.0, 3.0) if "--payload" in options else None
    arms = frozen_arms(load_arm(arm), payload=payload)
    for gravity in (False, True):
        space = workspace_of(arms, samples=1024, seed=77, gravity=gravity)
        loop = SampledLoop(gains["mbar"], gains["ks"], gains["beta"], 0.001)
        ends = [loop.scaled(mbar=x) for x in gains["gain_margin"]]
        ends += [SampledLoop(loop.mbar, loop.ks, loop.beta, 0.001, delay=gains["delay_margin_periods"])]
        assert max(space.radii(end).max() for end in ends) < 1.0
    return report


def test_two_link_keeps_the_margins_asked_for_with_gravity(asmc_pin):
    report = designed(asmc_pin, "two_link")
    gains = report["gains"]
    assert gains["met"]
    assert gains["useful"]
    assert gains["asked"] == {"gain_margin": [0.5, 2.0], "delay_margin_periods": 1.0}
    assert gains["gain_margin"][0] <= 0.5
    assert gains["gain_margin"][1] >= 2.0
    assert gains["delay_margin_periods"] >= 1.0
    np.testing.assert_allclose(gains["mbar"], gains["mbar_scale"] * np.array(report["mbar"]))


def test_one_mbar_is_printed_and_it_is_that_of_the_gains(asmc_pin):
    status, out, _ = asmc_pin("design", "two_link", "--gains", "--period", "0.001")
    assert status == 0
    lines = [line for line in out.splitlines() if line.startswith(("M̄ =", "M̄:"))]
    assert len(lines) == 1
    printed = [float(value) for value in lines[0].removeprefix("M̄ = ").split(",")]
    assert all(value < 0.04 for value in printed)  # the M̄ of least norm has 0.0444 twice
    assert "where searched: torque gain" in out


@pytest.mark.long
def test_ur5_with_a_payload_range_keeps_the_margins_at_both_ends(asmc_pin):
    gains = designed(asmc_pin, "ur5", "--payload", "0:3")["gains"]
    assert gains["met"]
    assert gains["useful"]


@pytest.mark.long
def test_so100_has_gains_that_hold_with_gravity(asmc_pin):
    assert designed(asmc_pin, "so100")["gains"]["met"]


@pytest.mark.long
@pytest.mark.parametrize("arm", ["z1", "panda"])
def test_gains_that_hold_but_are_slow_are_called_of_no_use_and_armature_is_priced(asmc_pin, arm):
    gains = designed(asmc_pin, arm)["gains"]
    assert gains["met"]
    assert not gains["useful"]
    assert gains["why"]
    assert all(math.isfinite(value) and value > 0.0 for value in gains["armature_wanted"])


@pytest.mark.long
def test_margins_that_cannot_be_had_are_status_0_with_those_that_can(asmc_pin):
    options = ("--gains", "--period", "0.001", "--gain-margin", "30")
    status, out, err = asmc_pin("design", "two_link", *options)
    assert status == 0, err
    assert "M̄ = " in out
    assert "no gains with the margins asked for were found: torque gain 0.03333 to 30, extra delay 1 periods" in out
    assert "where searched: torque gain" in out


def test_what_is_proven_of_the_gains_is_told_and_the_margins_are_not(asmc_pin):
    options = ("--gains", "--period", "0.001", "--payload", "0:1", "--certify", "--json")
    status, out, err = asmc_pin("design", "two_link", *options)
    assert status == 0, err
    gains = json.loads(out)["gains"]
    proof = gains["proof"]
    assert proof["verdict"] == "stable"
    assert proof["about"] == "the loop frozen at every q of the box, without gravity"
    assert gains["kind"] == "certified"
    low, high = proof["stable_between"]
    assert low < proof["seen_between"][0] < proof["seen_between"][1] < high


@pytest.mark.long
def test_a_loop_that_no_proof_is_made_for_is_searched_and_the_status_is_that_of_mbar(asmc_pin):
    options = ("design", "two_link", "--gains", "--period", "0.001", "--certify", "--encoder-bits", "17")
    status, out, err = asmc_pin(*options, "--json")
    assert status == 0, err
    report = json.loads(out)
    assert report["kind"] == "certified"
    assert report["gains"]["proof"]["verdict"] == "searched"
    assert report["gains"]["kind"] == "searched"
    assert report["gains"]["velocity"] == "difference"
    status, out, _ = asmc_pin(*options)
    assert "searched, not proven: velocity: 'difference' given" in out


def test_certificate_of_the_gains_goes_to_the_file_and_that_of_mbar_beside_it(asmc_pin, tmp_path):
    file = tmp_path / "gains.npz"
    options = ("--gains", "--period", "0.001", "--payload", "0:1", "--certify", "--certificate", str(file), "--json")
    status, out, err = asmc_pin("design", "two_link", *options)
    assert status == 0, err
    gains = json.loads(out)["gains"]
    assert sorted(path.name for path in tmp_path.iterdir()) == ["gains-mbar.npz", "gains.npz"]
    assert err.count("certificate: ") == 2
    status, out, _ = asmc_pin("check", str(file))
    assert status == 0
    assert "stable: the loop frozen at every q of the box" in out
    assert f"K_s = {gains['ks'][0]!r} I" in out
    assert f"β = {gains['beta']!r} 1/s" in out
    assert "0 to 1 kg" in out or "0:1 kg" in out
    status, out, _ = asmc_pin("check", str(tmp_path / "gains-mbar.npz"))
    assert status == 0
    assert "Lemma 1" in out


def test_where_no_proof_is_made_for_the_gains_no_file_of_them_is_written_and_it_is_said(asmc_pin, tmp_path):
    file = tmp_path / "gains.npz"
    options = ("--gains", "--period", "0.001", "--certify", "--certificate", str(file), "--encoder-bits", "17")
    status, _, err = asmc_pin("design", "two_link", *options)
    assert status == 0
    assert not file.exists()
    assert f"so no certificate was written to {file}" in err


def test_without_certify_no_proof_is_spoken_of_and_the_pid_stands_beside_the_gains(asmc_pin):
    status, out, _ = asmc_pin("design", "two_link", "--gains", "--period", "0.001", "--json")
    assert status == 0
    gains = json.loads(out)["gains"]
    assert gains["proof"] is None
    beta, ks = gains["beta"], gains["ks"][0]
    np.testing.assert_allclose(gains["pid"]["k"], np.array(gains["mbar"]) * (beta + ks) / 0.001)
    assert gains["pid"]["ti"] == pytest.approx((beta + ks) / (beta * ks))
    assert gains["pid"]["td"] == pytest.approx(1.0 / (beta + ks))


@pytest.mark.long
def test_a_noise_budget_chooses_the_filter_too(asmc_pin):
    options = (
        "design",
        "two_link",
        "--gains",
        "--period",
        "0.001",
        "--encoder-bits",
        "17",
        "--noise-budget",
        "0.3,0.1",
    )
    status, out, err = asmc_pin(*options, "--json")
    assert status == 0, err
    gains = json.loads(out)["gains"]
    assert gains["met"]
    assert gains["noise_met"]
    assert gains["filter_hz"] > 0.0
    assert all(rms <= most for rms, most in zip(gains["torque_noise_rms"], [0.3, 0.1], strict=True))


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("--noise-budget", "1", "--encoder-bits", "17"), "add --gains and --period"),
        (("--gains", "--period", "0.001", "--noise-budget", "1"), "add --encoder-bits"),
        (
            ("--gains", "--period", "0.001", "--encoder-bits", "17", "--noise-budget", "1,2,3"),
            "--noise-budget: 3 values",
        ),
        (("--gains", "--period", "0.001", "--encoder-side", "motor"), "--gear"),
    ],
)
def test_sensor_options_that_do_not_go_together_are_status_2(asmc_pin, options, said):
    status, _, err = asmc_pin("design", "two_link", *options)
    assert status == 2
    assert said in err


def test_stability_takes_the_ranges_that_design_takes(asmc_pin):
    ranges = ("--payload", "0:2", "--armature", "0,0.01:0.02", "--box", "joint_2=-1:1")
    status, out, err = asmc_pin("stability", "two_link", "--mbar", "0.02", *LOOP, *ranges, "--json")
    assert status == 0, err
    report = json.loads(out)
    assert report["payload"]["mass"] == [0.0, 2.0]
    assert report["armature"] == [0.0, [0.01, 0.02]]
    assert report["box"]["joint_2"] == [-1.0, 1.0]
    assert 0.01 <= report["worst_armature"][1] <= 0.02
    assert 0.0 <= report["rest_worst_payload"]["mass"] <= 2.0
    assert report["kind"] == "searched"


def test_stability_takes_choices_of_locked_joints(asmc_pin):
    options = ("--mbar", "0.01", *LOOP, "--lock", "wrist_3_joint=0,1")
    status, out, err = asmc_pin("stability", "ur5", *options, "--json")
    assert status in (0, 1), err
    report = json.loads(out)
    assert report["locked"] == {"wrist_3_joint": [0.0, 1.0]}
    assert report["worst_locked"]["wrist_3_joint"] in (0.0, 1.0)


def test_an_unstable_loop_is_status_1_with_one_remedy(asmc_pin):
    status, out, _ = asmc_pin(
        "stability", "two_link", "--mbar", "0.01", "--ks", "30", "--beta", "30", "--period", "0.001"
    )
    assert status == 1
    assert "the sampled loop is UNSTABLE" in out
    assert out.count("remedy: lower β and K_s") == 1


def test_a_law_without_a_choice_of_gains_is_refused_before_anything_is_searched(
    capsys: pytest.CaptureFixture[str],
) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["design", "two_link", "--gains", "--period", "0.001", "--law", "sta"])
    out, err = capsys.readouterr()
    assert (ended.value.code, out) == (2, "")
    assert "these have: dob, implicit" in err
    assert "looking for" not in err
