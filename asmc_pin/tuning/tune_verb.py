"""Tuning every controller of an experiment, from where it stands to its end."""

from __future__ import annotations

import hashlib
import shutil
import time
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path

from asmc_pin.disk.files import write_whole
from asmc_pin.disk.reading import user_path
from asmc_pin.disk.sole_writer import sole_writer
from asmc_pin.errors import ParameterError, ResultError
from asmc_pin.experiment import Experiment
from asmc_pin.pages.tunings.tune_findings import TuneFindings
from asmc_pin.results import result_folder
from asmc_pin.statistics.pairwise import pairwise
from asmc_pin.sweeping.sweep_key import sweep_key
from asmc_pin.tuning.candidate_runs import draws_of
from asmc_pin.tuning.controller_tuning import ControllerTuning, HeldOut
from asmc_pin.tuning.fair_score import Judge
from asmc_pin.tuning.tune_files import STUDIES, tuned_experiment, write_tuning
from asmc_pin.tuning.tune_result import Tuned
from asmc_pin.words.given import check_experiment
from asmc_pin.words.interface import option_words

BUDGET = 64
"""Candidates of each controller where nobody says."""

MOST_CANDIDATES = 100_000

Progress = Callable[[str, float], None]
"""Told what is being done, and which share of all is done, 0 to 1."""

_SEARCH = 0.9  # of the time, roughly


def tune(
    experiment: Experiment,
    trials: int = BUDGET,
    out: str | Path | None = None,
    *,
    force: bool = False,
    progress: Progress | None = None,
) -> Tuned:
    """Search gains for every controller of an experiment, all with the same budget, and judge the best held out.

    ``[tune]`` says what is made small, within which limits, over which gains and on how many draws of ``[sweep]``
    (docs/tuning.md). The first candidate of each controller is the file's own: where that keeps the limits and lies in
    the ranges, no result is worse on the training draws. A tuning that was killed goes on from the batches that it had
    stored and ends with the same result.

    Args:
        experiment: See `asmc_pin.load_experiment`.
        trials: Candidates of each controller, the file's own among them.
        out: Folder of the result; ``results/NAME-tune`` when omitted.
        force: Whether candidates of another experiment or version that lie there may be replaced.
        progress: Called now and then.

    Returns:
        The tuned experiment and what was found. A controller that fails throughout is no error: its figure is +∞.

    Raises:
        ResultError: something is there that may not be replaced, or cannot be written.
        ExperimentError: nothing varies at random, a range or a limit does not fit, or a law of one's own raised.
        ParameterError: an argument is out of range.
    """
    check_experiment(experiment)
    if isinstance(trials, bool) or int(trials) != trials or not 1 <= trials <= MOST_CANDIDATES:
        raise ParameterError("trials", f"{trials!r} given; expected a whole number from 1 to {MOST_CANDIDATES:,}")
    folder = user_path(out) if out is not None else Path("results") / f"{experiment.name}-tune"
    tell = progress or (lambda _what, _share: None)
    tell("loading", 0.0)
    points, judge = draws_of(experiment).grid_points, Judge(experiment)
    experiment.build_controllers()  # what does not fit the arm is said before anything is searched
    tunings = {label: ControllerTuning(experiment, label) for label in experiment.controllers}
    key = sweep_key(experiment)
    _prepare(folder)
    with sole_writer(folder):
        if force:
            shutil.rmtree(folder / STUDIES, ignore_errors=True)
            (folder / STUDIES).mkdir(exist_ok=True)
        return _run(experiment, trials, folder, tunings, judge, points, key, tell)


def _run(
    experiment: Experiment,
    trials: int,
    folder: Path,
    tunings: dict[str, ControllerTuning],
    judge: Judge,
    points: int,
    key: str,
    tell: Progress,
) -> Tuned:
    """Search what is not searched yet, and write what it comes to."""
    started, began = datetime.now(UTC), time.monotonic()
    journals = {label: folder / STUDIES / f"{_file_name(label)}.log" for label in tunings}
    for label, tuning in tunings.items():  # what lies there stays as it is, its experiment too, where it is another's
        tuning.check(journals[label], key)
    write_whole(folder / result_folder.EXPERIMENT, experiment.to_toml())
    judged: dict[str, tuple[ControllerTuning, HeldOut]] = {}
    found = []
    for i, (label, tuning) in enumerate(tunings.items()):

        def part(done: int, label: str = label, i: int = i) -> None:
            tell(f"{label}: {done} of {trials} candidates", _SEARCH * (i + done / trials) / len(tunings))

        winner = tuning.search(trials, journals[label], key, part)
        judged[label] = tuning, tuning.judged(winner)
        found.append(tuning.found(winner, judged[label][1], tuning.sensitivity(winner)))
    figures = {item.shown: tunings[item.label].by_draw(item.held_out) for item in found}
    findings = TuneFindings(
        experiment=experiment,
        objective=judge.words(),
        budget=int(trials),
        points=points,
        controllers=found,
        comparisons=pairwise({experiment.tune.objective: figures}, experiment.seed) if len(figures) > 1 else [],
        kinds=judge.kinds,
    )
    tell("writing", _SEARCH)
    tuned = tuned_experiment(experiment, {item.label: item.setting for item in found})
    path = write_tuning(folder, findings, tuned, judged, key, started, time.monotonic() - began)
    tell("done", 1.0)
    return Tuned(folder, path, tuned, findings)


def _file_name(label: str) -> str:
    """A name for the journal of a controller, whose label may hold what no file's name may."""
    plain = "".join(c if c.isascii() and (c.isalnum() or c in "-_") else "_" for c in label)[:60]
    return f"{plain}-{hashlib.sha256(label.encode()).hexdigest()[:8]}"


def _prepare(folder: Path) -> None:
    """Make the folder; refuse one whose files are no tuning's."""
    if folder.is_symlink() or (folder.exists() and not folder.is_dir()):
        raise ResultError(folder, f"{folder} is not a folder; give another one with {option_words('out')}")
    try:
        names = {path.name for path in folder.iterdir()} if folder.exists() else set()
        if names and STUDIES not in names:
            raise ResultError(
                folder,
                f"{folder} holds files that are no tuning, and is left alone; "
                f"give another folder with {option_words('out')}",
            )
        (folder / STUDIES).mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ResultError(folder, f"{folder} cannot be written: {error.strerror or error}") from error
