"""`asmc-pin bench`: what it prints, and that bad input is one message."""

import json

import pytest
from processes import run

PART = ("--quick", "--arm", "rv4fd", "--task", "reach", "--law", "ppc", "--law", "baek2016", "--workers", "1")


def test_json_says_what_was_run_and_how_the_laws_rank(tmp_path):
    done = run("bench", *PART, "--json", "--report", "page.md", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    said = json.loads(done.stdout)
    assert (said["out"], said["suite"]) == ("results/asmc-bench-1-part", "asmc-bench-1")
    assert "1 of 5 arms, 1 of 4 tasks" in said["part"]
    assert len(said["sha256"]) == 64
    assert {item["rank"]["mean"] for item in said["laws"].values()} == {1.0, 2.0}
    assert "# a part of asmc-bench-1: 2 laws on 1 problems" in (tmp_path / "page.md").read_text()
    assert (tmp_path / "page_profiles.png").is_file()


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (("asmc-bench-7",), "there is no suite 'asmc-bench-7'"),
        (("--arm", "ur55"), "did you mean 'ur5'"),
        (("--law", "baek"), "asmc-bench-1 has no 'baek'"),
        (("--report", "page.txt"), "ends in neither .html nor .md"),
    ],
)
def test_bad_input_is_one_message(arguments, told, tmp_path):
    wrong = run("bench", *arguments, cwd=tmp_path)
    assert (wrong.returncode, wrong.stdout) == (2, "")
    assert told in wrong.stderr
    assert wrong.stderr.count("\n") == 1
    assert not (tmp_path / "results").exists()
