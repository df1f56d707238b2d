"""The rows of a sweep: the same bits whatever the blocks, the workers and the batch; never stale; nothing lost."""

import re
import shutil
import signal
import time
import tracemalloc
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from sweep_cases import DATA, contents, tiny

from asmc_pin.engine import rollout
from asmc_pin.errors import ExperimentError, ParameterError, ResultError
from asmc_pin.metrics import METRICS, evaluate
from asmc_pin.sweeping import sweep
from asmc_pin.sweeping.block_rows import BlockRows
from asmc_pin.sweeping.row_files import read_shards
from asmc_pin.sweeping.sweep_key import sweep_key
from asmc_pin.sweeping.sweep_plan import sweep_plan
from asmc_pin.sweeping.sweep_verb import how_far
from asmc_pin.sweeping.sweep_workers import in_workers
from asmc_pin.sweeping.trial_replay import replay


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A sweep in one process, and the experiment."""
    folder = tmp_path_factory.mktemp("whole") / "tiny"
    return sweep(tiny(), 6, folder, workers=1, block=4), folder


def whole_rows(folder):
    return pq.read_table(folder / "rows.parquet").to_pandas()


def test_the_result_is_the_same_bytes_whatever_the_workers_and_the_blocks(whole, tmp_path):
    for name, workers, block in (("a", 1, 12), ("b", 2, 5)):
        sweep(tiny(), 6, tmp_path / name, workers=workers, block=block)
        made, known = contents(tmp_path / name), contents(whole[1])
        same = {path for path in known if not path.startswith("rows/")}
        assert {path for path in made if not path.startswith("rows/")} == same
        assert all(made[path] == known[path] for path in same)


@pytest.mark.parametrize("trial", [0, 3, 10])
def test_a_row_is_what_its_trial_gives_alone(whole, trial):
    """Each trial's own experiment, built from its tables and run by itself: the same bits as in the lockstep batch."""
    experiment = tiny()
    variation = experiment.variation
    tables = variation.tables(variation.quantities(trial))
    draw = variation.place_of(trial)[1]
    single = experiment.replace(**{**tables, "sweep": None, "trial": draw})
    rows = whole_rows(whole[1])
    for label, law in single.build_controllers().items():
        run = rollout(single.build_plant(), law, single.build_reference(), single.duration)
        here = rows[(rows.trial == trial) & (rows.controller == label)]
        for name, values in evaluate(run, single.metric_settings()).items():
            assert np.array_equal(here[name].to_numpy(), values[0], equal_nan=True), name


@pytest.mark.parametrize(
    "axes",
    [
        {"controllers.BSMC.gain": {"uniform": [1.0, 9.0]}, "plant.effort_limit": {"uniform": [20.0, 30.0]}},
        {"defaults.ks": {"uniform": [4.0, 6.0]}, "plant.q0": {"values": [[0.3, 0.2], [0.31, 0.2]]}},
        {"reference.move": {"uniform": [0.05, 0.1]}},
        {"plant.friction.breakaway": {"uniform": [1.0, 3.0]}, "plant.friction.presliding": {"values": [0.0, 500.0]}},
        {"arm.source": {"values": ["two_link", "so100"]}, "defaults.ks": {"factor": {"lognormal": 0.1}}},
        {"plant.substeps": {"values": [1, 2]}, "period": {"values": [0.001, 0.002]}},
        {"arm.payload.mass": {"lognormal": 0.2}, "arm.armature": {"uniform": [0.0, 0.1]}},
    ],
)
def test_lockstep_is_a_matter_of_speed_alone_whatever_varies(axes):
    """Blocks of one trial have nothing to share; rows in one block are the same."""
    changes = {}
    if "arm.source" in axes:
        changes = {"plant": {"friction": {"coulomb": 0.5}}, "defaults": {"mbar": 0.01, "ks": 5.0, "beta": 4.0}}
        still = {nv: {"kind": "quintic", "start": [0.1] * nv, "targets": [[0.12] * nv], "move": 0.1} for nv in (2, 5)}
        axes = {**axes, "reference": {"values": [still[2], still[5]], "with": "arm.source"}}
    experiment = tiny(axes, **changes)
    found = []
    for block in (1, 8):
        plan = sweep_plan(experiment, 3, block, "key")
        run = BlockRows(plan)
        found.append(pa.concat_tables([run.table(each) for each in plan.blocks]).to_pandas())
    assert len(found[0]) > 8
    assert found[0].equals(found[1])


def test_laws_that_know_the_model_know_the_arm_of_each_trial(tmp_path):
    laws, free = {"CT": {"law": "computed_torque"}}, {"friction": {"coulomb": 0.0}}
    made = sweep(
        tiny({"arm.payload": {"values": [0.0, 2.0]}}, controllers=laws, plant=free), 1, tmp_path / "s", workers=1
    )
    rows = whole_rows(made.out)
    assert set(rows.controller) == {"CT (knows the model)"}
    # It cancels each trial's own load, so that the errors are those of no load; 2 kg that it did not know would show.
    light, heavy = (rows[rows.trial == trial].rms_error.to_numpy() for trial in (0, 1))
    assert np.allclose(light, heavy, rtol=0.01, atol=0.0)
    single = tiny({"arm.payload": {"values": [0.0]}}, controllers=laws, plant=free)
    ignorant = rollout(
        single.replace(arm={"source": "two_link", "payload": 2.0}).build_plant(),
        single.replace(arm="two_link").build_controllers()["CT"],
        single.build_reference(),
        single.duration,
    )
    assert (METRICS["rms_error"](ignorant)[0] > 2.0 * light).any()


def test_all_controllers_meet_the_same_trial(whole):
    rows = whole_rows(whole[1])
    varied = [name for name in rows if name.startswith("sweep.")]
    assert len(varied) == 3
    for _, trial in rows.groupby(["trial", "joint"]):
        assert (trial[varied].nunique() == 1).all()
        assert len(trial) == 2


def told_of_progress(draws, folder):
    """What a sweep of blocks of four trials says, up to its page, which takes the longest and is not made."""
    told = []

    def tell(*each):
        told.append(each)
        if each[0] == "writing":
            raise InterruptedError

    with pytest.raises(InterruptedError):
        sweep(tiny(), draws, folder, workers=1, block=4, progress=tell)
    return told


def test_progress_says_how_many_trials_are_done_how_fast_and_how_long_the_rest_takes(tmp_path):
    told = told_of_progress(4, tmp_path / "s")
    assert told[1] == ("0 of 8 trials", 0.0)
    assert re.fullmatch(r"4 of 8 trials, [\d.e+]+ per s, \d+ (s|min|h) left", told[2][0])
    assert told[2][1] == 0.5
    assert told[3][0].startswith("8 of 8 trials, ")
    assert told[3][0].endswith(" per s, 0 s left")
    plan = sweep_plan(tiny(), 3000, 4, "key")  # 6,000 trials, of which 1,000 were there
    assert how_far(plan, 5000, 200, 200, 100.0) == "1,200 of 6,000 trials, 2 per s, 40 min left"
    assert how_far(plan, 5000, 2, 2, 10.0) == "1,002 of 6,000 trials, 0.2 per s, 7 h left"


def test_what_starting_took_is_not_in_the_rate_for_long(tmp_path, monkeypatch):
    """A block a second, after thirty seconds of starting."""
    clock = iter([0.0, *np.arange(30.0, 100.0)])
    monkeypatch.setattr("asmc_pin.sweeping.sweep_verb.time", SimpleNamespace(monotonic=lambda: next(clock)))
    told = [what for what, _ in told_of_progress(12, tmp_path / "s")]
    assert told[2] == "4 of 24 trials, 0.133 per s, 2 min left"
    assert told[5] == "16 of 24 trials, 4 per s, 2 s left"


def test_more_draws_keep_the_trials_that_were_there(whole, tmp_path):
    folder = tmp_path / "grown"
    shutil.copytree(whole[1], folder)
    first = (folder / "rows" / "000000000-000000003.parquet").stat().st_mtime_ns
    sweep(tiny(), 8, folder, workers=1, block=4)
    assert (folder / "rows" / "000000000-000000003.parquet").stat().st_mtime_ns == first
    rows, fewer = whole_rows(folder), whole_rows(whole[1])
    assert rows[: len(fewer)].equals(fewer)
    assert rows.trial.max() == 15
    with pytest.raises(ResultError, match="more trials than the 12 asked for"):
        sweep(tiny(), 6, folder, workers=1, block=4)


def test_a_stale_row_is_refused_and_never_reused(whole, tmp_path):
    folder = tmp_path / "stale"
    shutil.copytree(whole[1], folder)
    other = tiny(seed=6)
    with pytest.raises(ResultError, match="force=True replaces them"):
        sweep(other, 6, folder, workers=1, block=4)
    sweep(other, 6, folder, workers=1, block=4, force=True)
    sweep(other, 6, tmp_path / "fresh", workers=1, block=4)
    assert contents(folder) == contents(tmp_path / "fresh")


def test_the_key_changes_with_experiment_urdf_and_code(tmp_path, monkeypatch):
    from paths import REPOSITORY

    urdf = tmp_path / "arm.urdf"
    urdf.write_bytes((REPOSITORY / "urdf" / "two_link" / "two_link.urdf").read_bytes())
    own = {"arm": {"source": str(urdf), "payload": 0.5}}
    keys = [sweep_key(tiny()), sweep_key(tiny(seed=6)), sweep_key(tiny(**own))]
    urdf.write_text(urdf.read_text().replace("<robot", "<!-- changed --><robot"))
    keys.append(sweep_key(tiny(**own)))
    monkeypatch.setattr("asmc_pin.sweeping.sweep_key.code_key", lambda: "another version")
    keys.append(sweep_key(tiny()))
    assert len(set(keys)) == len(keys)
    monkeypatch.undo()
    assert sweep_key(tiny()) == keys[0]


def test_a_damaged_shard_is_computed_anew(whole, tmp_path):
    folder = tmp_path / "damaged"
    shutil.copytree(whole[1], folder)
    shard = folder / "rows" / "000000004-000000007.parquet"
    shard.write_bytes(shard.read_bytes()[:-20])
    sweep(tiny(), 6, folder, workers=1, block=4)
    assert contents(folder) == contents(whole[1])
    data = bytearray(shard.read_bytes())
    page = pq.ParquetFile(shard).metadata.row_group(0).column(20)
    data[page.data_page_offset + page.total_compressed_size - 20] ^= 0xFF  # within a page: its checksum tells
    shard.write_bytes(bytes(data))
    with pytest.raises(ResultError, match="damaged"):
        sweep(tiny(), 6, folder, workers=1, block=4)
    sweep(tiny(), 6, folder, workers=1, block=4)
    assert contents(folder) == contents(whole[1])


def test_a_draw_that_fits_no_experiment_names_its_trial(tmp_path):
    sweeping = tiny({"arm.payload": {"normal": [0.6, 0.5]}})
    bad = next(t for t in range(200) if sweeping.variation.quantities(t)["arm.payload"] < 0.0)
    for workers in (1, 2):
        with pytest.raises(ExperimentError, match=rf"trial {bad}: .*arm\.payload\.mass"):
            sweep(sweeping, bad + 1, tmp_path / str(workers), workers=workers, block=bad // 2 + 1)


@pytest.mark.long
def test_a_worker_that_is_killed_is_one_message_and_no_fault_of_ours():
    with pytest.raises(ParameterError, match=r"ended one of the processes.*the same command goes on from there"):
        list(in_workers(signal.raise_signal, [signal.SIGKILL] * 3, 2))


@pytest.mark.long
def test_workers_that_are_given_up_in_mid_run_warn_of_nothing(recwarn):
    """What is wrong is one message; joblib has advice on top, about tasks that were cancelled."""
    done = in_workers(time.sleep, [0.02] * 30, 2)
    next(done)
    done.close()
    assert [str(item.message) for item in recwarn.list] == []


def test_a_folder_that_is_no_sweep_is_left_alone(tmp_path):
    (tmp_path / "thesis.tex").write_text("mine")
    with pytest.raises(ResultError, match="no sweep"):
        sweep(tiny(), 1, tmp_path, workers=1)
    assert [path.name for path in tmp_path.iterdir()] == ["thesis.tex"]
    with pytest.raises(ParameterError, match="workers"):
        sweep(tiny(), 1, tmp_path / "new", workers=0)
    with pytest.raises(ParameterError, match="trials"):
        sweep(tiny(), 0, tmp_path / "new", workers=1)


def test_a_replay_has_the_figures_of_its_rows_and_its_experiment_runs_alone(whole, tmp_path):
    folder = tmp_path / "again"
    shutil.copytree(whole[1], folder)
    made = replay(tiny(), 6, 7, folder)
    rows = whole_rows(folder)
    assert (folder / "replay" / "7" / "report.html").is_file()
    first = made.rows[made.rows.trial == 0]
    for name in METRICS:
        assert np.array_equal(first[name].to_numpy(), rows[rows.trial == 7][name].to_numpy(), equal_nan=True), name
    with pytest.raises(ParameterError, match="0 to 11"):
        replay(tiny(), 6, 12, folder)


def test_a_replay_beside_rows_of_another_version_says_that_it_is_not_held_against_them(whole, monkeypatch):
    told = []
    made = SimpleNamespace(rows=pd.DataFrame({"trial": [0]}))
    monkeypatch.setattr("asmc_pin.sweeping.trial_replay.compare", lambda *_, **__: made)
    other = tiny(seed=6)
    assert replay(other, 6, 7, whole[1], warn=told.append) is made
    assert told == [f"{whole[1]} holds rows of another experiment, URDF or version; this run is not held against them"]
    scanned = tiny({"arm.payload": {"scan": [0.0, 8.0]}})
    with pytest.raises(ParameterError, match=r"only rows of another experiment.* sweep it again with force=True"):
        replay(scanned, 6, 1, whole[1])


def test_an_experiment_with_a_tool_has_its_error_in_the_rows_and_a_replay_has_the_same(tmp_path):
    experiment = tiny(metrics={"tool": "tip"})
    sweep(experiment, 2, tmp_path / "s", workers=1, block=4)
    rows = whole_rows(tmp_path / "s")
    assert (rows.groupby(["trial", "controller"]).tool_rms_position.nunique() == 1).all()
    assert ((rows.tool_rms_position > 0.0) & (rows.tool_rms_position < rows.tool_max_position)).all()
    made = replay(experiment, 2, 3, tmp_path / "s")  # it holds the rows against its own figures
    again = made.rows[made.rows.trial == 0].tool_max_rotation.to_numpy()
    assert np.array_equal(again, rows[rows.trial == 3].tool_max_rotation.to_numpy())


def test_what_a_worker_keeps_does_not_grow_with_the_trials(monkeypatch):
    """Neither arms nor laws nor rows of blocks that are done stay behind."""
    monkeypatch.setattr("asmc_pin.sweeping.trial_runs._KEPT", 4)
    plan = sweep_plan(tiny({**DATA["sweep"], "reference.move": {"uniform": [0.05, 0.1]}}), 1000, 1, "key")
    run, kept = BlockRows(plan), []
    tracemalloc.start()
    try:
        for block in plan.blocks[:30]:
            run.parquet(block)
            kept.append(tracemalloc.get_traced_memory()[0])
    finally:
        tracemalloc.stop()
    # An experiment with its arm and motion is some 50 kB: twenty that stayed would be 1 MB.
    assert kept[-1] - kept[9] < 3e5


def test_the_memory_of_a_block_does_not_grow_with_its_trials(monkeypatch):
    """However many trials a block has, the histories of a few are held at once."""
    monkeypatch.setattr("asmc_pin.sweeping.block_rows.TOGETHER", 4)
    plan = sweep_plan(tiny(duration=2.0), 200, 32, "key")
    run, peaks = BlockRows(plan), {}
    run.parquet(range(4))
    for trials in (4, 8, 64):
        tracemalloc.start()
        try:
            run.parquet(range(trials))
            peaks[trials] = tracemalloc.get_traced_memory()[1]
        finally:
            tracemalloc.stop()
    # Histories of four trials of 1,001 ticks are some MB; all 64 at once would be sixteen times as much.
    assert peaks[64] < 2.0 * peaks[4]


def test_rows_that_another_sweep_left_in_the_place_of_ones_own_are_in_no_figure(tmp_path):
    """Where no lock is to be had, as between two machines, the key of the rows tells."""
    mine, other = tiny(), tiny(duration=0.06)
    sweep(mine, 2, tmp_path / "a", workers=1)
    sweep(other, 2, tmp_path / "b", workers=1)
    (shard,) = (tmp_path / "b" / "rows").iterdir()
    shutil.copy(shard, tmp_path / "a" / "rows" / shard.name)
    plan = sweep_plan(mine, 2, None, sweep_key(mine))
    with pytest.raises(ResultError, match="rows of another sweep"):
        list(read_shards(plan, tmp_path / "a"))
