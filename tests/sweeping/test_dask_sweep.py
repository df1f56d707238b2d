"""A sweep on a Dask cluster: a real scheduler and its workers, and nothing is lost whatever of them is."""

import os
import signal
import time

import distributed
import pytest
from dask_cluster import dask_cluster
from processes import run
from sweep_cases import contents, tiny

from asmc_pin.errors import ExperimentError, MissingDependencyError, ParameterError
from asmc_pin.sweeping import dask_workers, sweep
from asmc_pin.sweeping.sweep_plan import sweep_plan

DRAWS, SIZE = 60, 4  # 30 blocks


@pytest.fixture(scope="module")
def here(tmp_path_factory):
    """The same sweep by this process alone."""
    folder = tmp_path_factory.mktemp("here") / "tiny"
    sweep(tiny(), DRAWS, folder, workers=1, block=SIZE)
    return contents(folder)


class KillsAWorker:
    """Told of the progress, kills the process of a worker once some blocks are done, and counts what it had.

    Args:
        client: Of its cluster.
    """

    def __init__(self, client):
        self.client, self.told, self.had = client, 0, 0
        self.pids = client.run(os.getpid)

    def blocks(self, of):
        """The blocks that each worker has of what the client is asked for."""
        return {worker: [key for key in keys if str(key).startswith("block-")] for worker, keys in of().items()}

    def kill(self, worker, had):
        self.had = len(had)
        os.kill(self.pids[worker], signal.SIGKILL)
        while worker in self.client.nthreads():
            time.sleep(0.01)


class KillsOneThatRuns(KillsAWorker):
    """Kills a worker with blocks to run: a task without end holds it up; it still has them when it is killed."""

    def __call__(self, _what, _share):
        self.told += 1
        if self.told == 1:
            self.held = next(iter(self.pids))
            self.without_end = self.client.submit(time.sleep, 3600, workers=[self.held])
        elif self.told >= 9 and not self.had and (blocks := self.blocks(self.client.processing)[self.held]):
            self.kill(self.held, blocks)


class KillsOneWithRows(KillsAWorker):
    """Kills a worker with rows that are done and that nobody has fetched: nobody does while this is told."""

    def __call__(self, _what, _share):
        self.told += 1
        if self.told != 9:
            return
        while any(self.blocks(self.client.processing).values()):
            time.sleep(0.01)
        done = self.blocks(self.client.has_what)
        worker = max(done, key=lambda name: len(done[name]))
        self.kill(worker, done[worker])


@pytest.mark.long
@pytest.mark.parametrize("kind", [KillsOneThatRuns, KillsOneWithRows], ids=["being run", "done and not fetched"])
def test_a_cluster_that_loses_a_worker_in_mid_run_gives_the_bytes_of_one_process(here, tmp_path, kind):
    # What a worker was given to run stays with it.
    with dask_cluster(tmp_path, 2, DASK_DISTRIBUTED__SCHEDULER__WORK_STEALING="False") as cluster:
        with distributed.Client(cluster.address, set_as_default=False) as client:
            client.wait_for_workers(2)
            kills = kind(client)
            sweep(tiny(), DRAWS, tmp_path / "there", dask=cluster.address, block=SIZE, progress=kills)
        assert sum(worker.poll() is not None for worker in cluster.workers) == 1
    assert kills.had >= 1, "it had nothing to lose"
    assert contents(tmp_path / "there") == here
    sweep(tiny(), DRAWS, tmp_path / "loky", workers=2, block=SIZE)
    assert contents(tmp_path / "loky") == here


@pytest.mark.long
def test_a_lost_scheduler_is_one_message_and_the_sweep_goes_on_elsewhere(here, tmp_path, capfd):
    with dask_cluster(tmp_path, 1) as cluster:
        told = []

        def lose(what, _share):
            told.append(what)
            if len(told) == 6:
                cluster.scheduler.kill()

        with pytest.raises(ParameterError, match="the same command goes on from there"):
            sweep(tiny(), DRAWS, tmp_path / "there", dask=cluster.address, block=SIZE, progress=lose)
    assert "Traceback" not in capfd.readouterr().err
    kept = {path: path.stat().st_mtime_ns for path in (tmp_path / "there" / "rows").iterdir()}
    assert len(kept) >= 4
    sweep(tiny(), DRAWS, tmp_path / "there", workers=1, block=SIZE)
    assert {path: path.stat().st_mtime_ns for path in kept} == kept
    assert contents(tmp_path / "there") == here


@pytest.mark.long
def test_a_worker_with_other_code_or_a_trial_that_cannot_be_built_ends_it_with_its_name(tmp_path, monkeypatch):
    with dask_cluster(tmp_path, 1) as cluster:
        odd = tiny({"arm.payload": {"normal": [0.6, 0.5]}})
        bad = next(t for t in range(200) if odd.variation.quantities(t)["arm.payload"] < 0.0)
        with pytest.raises(ExperimentError, match=rf"worker tcp://.*trial {bad}: .*arm\.payload\.mass"):
            sweep(odd, bad + 1, tmp_path / "odd", dask=cluster.address)
        monkeypatch.setattr("asmc_pin.sweeping.sweep_key.code_key", lambda: "of another version")
        with pytest.raises(ExperimentError, match=r"worker tcp://.*another version of"):
            sweep(tiny(), 2, tmp_path / "new", dask=cluster.address)


def test_a_block_whose_workers_die_again_and_again_ends_the_sweep(tmp_path, monkeypatch):
    """Dask gives a block up after some deaths; we hand it over again, and not for ever."""
    monkeypatch.setattr(dask_workers, "LOSSES", 1)
    given_up = []

    class Killer(distributed.KilledWorker):
        def __init__(self):
            Exception.__init__(self, "it died with every worker")

        def __str__(self):
            return "it died with every worker"

    class Future:
        status = "error"

        def __init__(self, key):
            self.key = key

        def result(self):
            given_up.append(self.key)
            raise Killer

    class Done(list):
        add = list.append

        def __next__(self):
            return self.pop()

    class Client:
        loop = None

        def nthreads(self):
            return {"a": 1}

        def submit(self, *_, key, pure):
            return Future(key)

    class Pretended:
        KilledWorker = distributed.KilledWorker

        @staticmethod
        def as_completed(loop):
            return Done()

    plan = sweep_plan(tiny(), 1, 1, "key")
    with pytest.raises(ParameterError, match="trials 0 to 0 came to no end: it died with every worker"):
        list(dask_workers._results(Pretended, Client(), plan, [range(1)], "tcp://x"))
    assert len(given_up) == 2


def test_a_worker_of_several_threads_is_refused_with_the_command_for_several_workers():
    class Client:
        loop = None

        def nthreads(self):
            return {"tcp://a": 1, "tcp://b": 4}

    plan = sweep_plan(tiny(), 1, 1, "key")
    with pytest.raises(ParameterError, match=r"worker tcp://b has 4 threads; .*--nthreads 1 --nworkers 4"):
        list(dask_workers._results(distributed, Client(), plan, [range(1)], "tcp://x"))


def test_no_scheduler_no_worker_or_no_dask_is_one_message(tmp_path, monkeypatch):
    with monkeypatch.context() as hurried:
        hurried.setattr(dask_workers, "PATIENCE", 1.0)
        for address in ("tcp://127.0.0.1:1", "nonsense"):
            with pytest.raises(ParameterError, match=f"no Dask scheduler answers at '{address}'"):
                sweep(tiny(), 1, tmp_path / "s", dask=address)

    class HurriedClient(distributed.Client):  # for workers alone: a scheduler on a busy machine takes its time
        def wait_for_workers(self, n_workers, timeout):
            return super().wait_for_workers(n_workers, timeout=1.0)

    monkeypatch.setattr(distributed, "Client", HurriedClient)
    with dask_cluster(tmp_path, 0) as cluster, pytest.raises(ParameterError, match="has no worker"):
        sweep(tiny(), 1, tmp_path / "s", dask=cluster.address)
    monkeypatch.setitem(__import__("sys").modules, "distributed", None)
    with pytest.raises(MissingDependencyError, match=r"asmc-pin\[dask\]"):
        sweep(tiny(), 1, tmp_path / "s", dask="tcp://127.0.0.1:1")


def test_a_cluster_and_processes_at_once_are_bad_input(tmp_path):
    (tmp_path / "tiny.toml").write_text(tiny().to_toml())
    wrong = run("sweep", "tiny.toml", "--trials", "2", "--workers", "2", "--dask", "tcp://127.0.0.1:1", cwd=tmp_path)
    assert (wrong.returncode, wrong.stdout) == (2, "")
    assert "expected one of them" in wrong.stderr
