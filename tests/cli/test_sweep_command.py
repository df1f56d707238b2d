"""`asmc-pin sweep`: what it prints, and that Ctrl-C ends it and its workers at once."""

import json
import os
import signal
import subprocess
import time

import numpy as np
import pyarrow.parquet as pq
import pytest
from next_command import next_words
from processes import command, environment, group_lives, run
from sweep_cases import contents, tiny


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    folder = tmp_path_factory.mktemp("sweep")
    (folder / "tiny.toml").write_text(tiny().to_toml())
    return folder, run("sweep", "tiny.toml", "--trials", "6", "--workers", "1", "--json", cwd=folder)


def test_json_says_where_the_rows_are_who_failed_and_who_is_better(done):
    folder, first = done
    assert first.returncode == 0, first.stderr
    said = json.loads(first.stdout)
    assert (said["out"], said["trials"], said["failed"]) == ("results/tiny-sweep", 12, {"PPC": 0, "BSMC": 0})
    keys = {"metric", "better", "worse", "ratio", "low", "high", "p"}
    assert all(keys <= set(item) and item["low"] <= item["ratio"] <= item["high"] for item in said["comparisons"])
    assert len(said["comparisons"]) == 3
    written = pq.read_table(folder / "results" / "tiny-sweep" / "comparisons.parquet").to_pandas()
    overall = written[written.point.isna()]
    assert overall.ratio.tolist() == [item["ratio"] for item in said["comparisons"]]
    assert len(written) == 9


def test_started_again_it_computes_nothing_and_prints_for_a_person(done):
    folder, _ = done
    rows = folder / "results" / "tiny-sweep" / "rows"
    before = {path.name: path.stat().st_mtime_ns for path in rows.iterdir()}
    again = run("sweep", "tiny.toml", "--trials", "6", cwd=folder)
    assert again.returncode == 0, again.stderr
    assert {path.name: path.stat().st_mtime_ns for path in rows.iterdir()} == before
    lines = again.stdout.splitlines()
    assert lines[0] == "tiny: PPC, BSMC in 6 draws at 2 points"
    assert "report: results/tiny-sweep/report.html" in lines
    *command_again, trial = next_words(again.stdout)
    assert command_again == ["sweep", "tiny.toml", "--trials", "6", "--replay"]
    found = pq.read_table(folder / "results" / "tiny-sweep" / "rows.parquet").to_pandas()
    over_joints = found.assign(log=np.log(found.rms_error)).groupby(["trial", "controller"]).log.mean()
    assert int(trial) == over_joints.idxmax()[0]


@pytest.mark.long
def test_a_replay_is_a_result_of_compare(done):
    folder, _ = done
    again = run("sweep", "tiny.toml", "--trials", "6", "--replay", "5", "--json", cwd=folder)
    assert again.returncode == 0, again.stderr
    assert json.loads(again.stdout)["out"] == "results/tiny-sweep/replay/5"
    wrong = run("sweep", "tiny.toml", "--trials", "6", "--replay", "12", cwd=folder)
    assert (wrong.returncode, wrong.stdout) == (2, "")
    assert "the trials of this sweep are 0 to 11" in wrong.stderr


def test_bad_input_is_one_message(tmp_path):
    (tmp_path / "bad.toml").write_text(tiny().to_toml().replace('"arm.payload"', '"arm.paylod"'))
    wrong = run("sweep", "bad.toml", "--trials", "2", cwd=tmp_path)
    assert (wrong.returncode, wrong.stdout) == (2, "")
    assert "did you mean 'payload'" in wrong.stderr
    assert wrong.stderr.count("\n") == 1
    assert not (tmp_path / "results").exists()


def test_ctrl_c_is_130_ends_the_workers_and_loses_no_block(tmp_path):
    (tmp_path / "tiny.toml").write_text(tiny(duration=1.0).to_toml())
    arguments = command("sweep", "tiny.toml", "--trials", "4000", "--workers", "2")
    process = subprocess.Popen(
        arguments, env=environment(), cwd=tmp_path, stderr=subprocess.PIPE, text=True, start_new_session=True
    )
    try:
        deadline = time.monotonic() + 280
        while len(list(tmp_path.glob("results/*/rows/*.parquet"))) < 2:
            assert time.monotonic() < deadline
            assert process.poll() is None
            time.sleep(0.05)
        os.killpg(process.pid, signal.SIGINT)  # as a terminal does: to the whole group
        err = process.communicate(timeout=300)[1]
        assert process.returncode == 130
        assert err.splitlines()[-1] == "asmc-pin: interrupted; nothing half-written was left behind"
        assert "Traceback" not in err, err
        assert "KeyboardInterrupt" not in err
        deadline = time.monotonic() + 120  # joblib's workers leave by themselves after 300 s
        while group_lives(process.pid):
            assert time.monotonic() < deadline, "a worker outlives the sweep"
            time.sleep(0.1)
        shards = contents(tmp_path / "results" / "tiny-sweep")
        assert not [name for name in shards if name.split("/")[-1].startswith(".")]
    finally:
        if group_lives(process.pid):
            os.killpg(process.pid, signal.SIGKILL)
