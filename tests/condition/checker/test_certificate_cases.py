"""Certificates that strangers made, by hand and by accident: what `asmc-pin check` once said of each was false.

``forge1``: M̄ = 100 on the two-link arm (norm 4385), no statement, every figure NaN. ``forge2``: a true proof of the
two-link arm under another arm's name and hash. ``viol_nan``: a refuted scale that is NaN. ``levelinf``: an infinite
level. The rest: damaged, foreign and deeply nested files.
"""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from paths import CASES

from asmc_pin import load_arm
from asmc_pin.cli import main
from asmc_pin.condition.certificate import certify
from asmc_pin.condition.checker import check

INPUTS = CASES / "certificates"


def checked(name: str, capsys: pytest.CaptureFixture[str], *options: str) -> tuple[int, str, str]:
    with pytest.raises(SystemExit) as stop:
        main(["check", str(INPUTS / name), *options])
    out, err = capsys.readouterr()
    assert isinstance(stop.value.code, int)
    return stop.value.code, out, err


@pytest.mark.parametrize("name", ["forge1.json", "viol_nan.npz", "levelinf.npz"])
def test_a_forged_certificate_is_not_valid(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    status, out, _ = checked(name, capsys)
    assert status == 1
    assert "NOT VALID: it proves nothing" in out
    assert "holds" not in out
    assert "violated" not in out
    status, out, _ = checked(name, capsys, "--json")
    said = json.loads(out)
    assert status == 1
    assert (said["valid"], said["verdict"], said["arm"], said["scale_proven"]) == (False, None, None, None)
    assert said["problems"]


def test_a_certificate_names_the_arm_that_is_inside(capsys: pytest.CaptureFixture[str]) -> None:
    status, out, _ = checked("forge2.json", capsys)
    assert status == 0
    assert "two_link" in out
    assert "ur5" not in out
    assert "cede880f" not in out
    _, out, _ = checked("forge2.json", capsys, "--json")
    said = json.loads(out)
    assert said["arm"] == "two_link"
    assert said["sha256"].startswith("c912102b")
    assert said["box"]["joint_2"] == pytest.approx([-3.14159, 3.14159], abs=1e-4)


@pytest.mark.parametrize("name", ["flip10.npz", "plain.npy", "deep.npz"])
def test_a_file_that_is_no_certificate_is_bad_input(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    status, out, err = checked(name, capsys)
    assert (status, out) == (2, "")
    assert err.count("\n") == 1
    assert "is not a certificate" in err


def test_a_verdict_at_a_level_says_that_it_is_about_the_level(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    proof = certify(load_arm("two_link"), 0.01, level=0.995, budget=10.0).save(tmp_path / "level.cert")
    with pytest.raises(SystemExit) as stop:
        main(["check", str(proof)])
    assert stop.value.code == 0
    assert "the verdict is about ‖I − M⁻¹M̄‖₂ < 0.995" in capsys.readouterr().out
    assert check(proof).to_json_dict()["level"] == 0.995
    bare = INPUTS / "forge2.json"
    assert check(bare).to_json_dict()["level"] == 1.0
