"""`asmc-pin tune`: what it prints, and that bad input is one message."""

import json

import pytest
from next_command import next_words
from processes import run
from tune_cases import small

from asmc_pin.experiment import load_experiment


@pytest.mark.long
def test_json_says_where_the_tuned_experiment_is_and_how_each_controller_did(tmp_path):
    (tmp_path / "small.toml").write_text(small().to_toml())
    done = run("tune", "small.toml", "--trials", "2", "--json", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    said = json.loads(done.stdout)
    assert (said["out"], said["experiment"]) == ("results/small-tune", "results/small-tune/tuned.toml")
    assert set(said["controllers"]) == {"PPC", "BSMC"}
    for item in said["controllers"].values():
        assert item["trials"] == 2
        assert item["train"] <= item["file"]["train"]
        assert item["held_out"] > 0.0
    assert load_experiment(tmp_path / said["experiment"]).controllers["PPC"]["beta"] > 0.0
    report = run("tune", "small.toml", "--trials", "2", "--report", "page.md", cwd=tmp_path)
    assert report.returncode == 0, report.stderr
    assert report.stdout.splitlines()[0] == "small: PPC, BSMC, tuned"
    assert next_words(report.stdout) == ["compare", "results/small-tune/tuned.toml"]
    assert "## Held out" in (tmp_path / "page.md").read_text()
    assert (tmp_path / "page_pareto.png").is_file()


def test_bad_input_is_one_message(tmp_path):
    (tmp_path / "bad.toml").write_text(small(sweep={}).to_toml())
    wrong = run("tune", "bad.toml", cwd=tmp_path)
    assert (wrong.returncode, wrong.stdout) == (2, "")
    assert "nothing in it is drawn at random" in wrong.stderr
    assert wrong.stderr.count("\n") == 1
    assert not (tmp_path / "results").exists()
