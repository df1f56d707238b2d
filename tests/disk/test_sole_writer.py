"""Long runs that fill a folder file by file: one at a time, and a full disk is one message with a name in it."""

from __future__ import annotations

import errno
import os
import resource

import pytest
from processes import run
from sweep_cases import DATA, contents, tiny

import asmc_pin
from asmc_pin.disk.sole_writer import sole_writer
from asmc_pin.errors import ResultError
from asmc_pin.experiment import Experiment
from asmc_pin.sweeping import sweep


def test_while_one_sweep_writes_another_is_refused_and_touches_nothing(tmp_path):
    """Two sweeps of different gains in one folder once printed figures made of both."""
    folder = tmp_path / "both"
    (folder / "rows").mkdir(parents=True)
    with sole_writer(folder), pytest.raises(ResultError, match="another run is writing into"):
        sweep(tiny(), 2, folder, workers=1)
    assert contents(folder) == {}
    assert sweep(tiny(), 2, folder, workers=1).findings.draws == 2


def test_while_one_tuning_writes_another_is_refused_even_with_force_and_takes_nothing_away(tmp_path):
    folder = tmp_path / "tuned"
    (folder / "studies").mkdir(parents=True)
    (folder / "studies" / "PPC-12345678.log").write_text("hours of work")
    experiment = Experiment.from_dict(DATA | {"sweep": {"arm.payload": {"uniform": [0.0, 0.5]}}})
    with sole_writer(folder), pytest.raises(ResultError, match="another run is writing into"):
        asmc_pin.tune(experiment, 1, folder, force=True)
    assert (folder / "studies" / "PPC-12345678.log").read_text() == "hours of work"


def test_a_folder_is_free_again_after_an_error_in_it(tmp_path):
    with pytest.raises(ZeroDivisionError), sole_writer(tmp_path):
        raise ZeroDivisionError
    with sole_writer(tmp_path):
        pass


def test_a_full_disk_is_told_with_the_folder_where_a_library_does_not_name_its_file(tmp_path):
    full = OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
    with (
        pytest.raises(ResultError, match="cannot be written: No space left on device; make room"),
        sole_writer(tmp_path),
    ):
        raise full


def test_a_sweep_that_runs_out_of_room_says_where_and_goes_on_when_there_is_some(tmp_path):
    experiment, folder = tmp_path / "small.toml", tmp_path / "out"
    experiment.write_text(tiny().to_toml(), encoding="utf-8")
    given = "sweep", str(experiment), "--trials", "2", "--workers", "1", "--out", str(folder)
    room = 20_000  # for the rows, not for a figure

    def limited() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (room, room))

    short = run(*given, preexec_fn=limited)
    assert short.returncode == 2
    assert str(folder) in short.stderr.splitlines()[-1]
    assert "File too large" in short.stderr
    assert run(*given).returncode == 0
