"""One Optuna study for one controller: batches of settings, each run in lockstep, each stored when it is whole.

The sampler of a batch is seeded by the number of the batch alone, and what it knows are the settings before it. So a
study that was killed goes on from its last whole batch and ends as if nothing had happened.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from asmc_pin.errors import ResultError
from asmc_pin.study.law_study import quiet_optuna
from asmc_pin.tuning.fair_score import Score
from asmc_pin.tuning.search_space import SearchSpace
from asmc_pin.words.interface import flag_words, option_words

BATCH = 16
"""Settings that are proposed together, and run in one batch."""

_SCORED = ("error", "excess", "chatter", "failed")

Evaluate = Callable[[Sequence[Mapping[str, Any]]], list[Score]]
"""Scores of settings, in their order."""


@dataclass(frozen=True)
class Candidate:
    """A setting that was tried.

    Attributes:
        number: In the order of the study; 0 is the file's own.
        factors: By name, on the start; empty for one that is outside the ranges.
        setting: The parameters, as TOML takes them.
        score: What the training trials came to.
        chosen: Whether it may win: the file's own may not where it is outside the ranges that were asked for.
    """

    number: int
    factors: Mapping[str, float]
    setting: Mapping[str, Any]
    score: Score
    chosen: bool = True


class GainStudy:
    """A study, from where its storage stands to its budget.

    Args:
        space: What is searched.
        seed: Of the experiment.
        storage: Journal of Optuna; a folder that is there holds it.
        key: Of all that the scores depend on; a journal with another one is not used.
    """

    def __init__(self, space: SearchSpace, seed: int, storage: Path | None, key: str) -> None:
        self._space, self._seed, self._storage, self._key = space, seed, storage, key

    def check(self) -> None:
        """See whether the journal may be used, before anything is written.

        Raises:
            ResultError: it is of another tuning.
        """
        with quiet_optuna():
            self._stored()

    def run(self, trials: int, evaluate: Evaluate, progress: Callable[[int], None]) -> list[Candidate]:
        """Try settings until there are `trials` of them; one if there is nothing to search.

        Args:
            trials: The budget.
            evaluate: Runs settings.
            progress: Told how many are done.

        Raises:
            ResultError: the journal is of another tuning.
        """
        with quiet_optuna():
            return self._run(trials if self._space.ranges else 1, evaluate, progress)

    def _run(self, trials: int, evaluate: Evaluate, progress: Callable[[int], None]) -> list[Candidate]:
        import optuna

        found = self._stored()[:trials]
        # Whole batches only: a shorter one at the end was of a smaller budget, or of a run that was killed.
        found = found if len(found) == trials else found[: len(found) - len(found) % BATCH]
        while len(found) < trials:
            progress(len(found))
            first, count = len(found), min(BATCH, trials - len(found))
            # A study of its own for each batch, of what is known before it: as a run that begins here has it.
            study = optuna.create_study(sampler=self._sampler(first))
            study.add_trials([_frozen(item, self._space) for item in found if item.chosen])
            batch = [self._own()] if first == 0 else []
            for trial in [study.ask() for _ in range(count - len(batch))]:
                factors = {
                    name: trial.suggest_float(name, low, high, log=True)
                    for name, (low, high) in self._space.ranges.items()
                }
                batch.append((factors, self._space.setting(factors), True))
            scores = evaluate([setting for _, setting, _ in batch])
            made = [
                Candidate(first + i, factors, setting, score, chosen)
                for i, ((factors, setting, chosen), score) in enumerate(zip(batch, scores, strict=True))
            ]
            found += made
            self._store(found, made)
        progress(trials)
        return found

    def _sampler(self, first: int) -> Any:
        """The sampler of the batch that begins here: the same random numbers for every controller."""
        import optuna

        seed = (self._seed * 1_000_003 + first) % 2**32
        return optuna.samplers.TPESampler(seed=seed, multivariate=True, constant_liar=True)

    def _own(self) -> tuple[dict[str, float], dict[str, Any], bool]:
        inside = self._space.holds_the_start
        return dict.fromkeys(self._space.ranges, 1.0) if inside else {}, self._space.start(), inside

    def _stored(self) -> list[Candidate]:
        """What the journal holds, in order, up to the first gap."""
        if self._storage is None or not self._storage.is_file():
            return []
        try:
            study = self._journal(self._storage, new=False)
            known, trials = study.user_attrs.get("key"), study.get_trials(deepcopy=False)
        except OSError:  # of the world, not of what stands in it: nothing is thrown away for that
            raise
        except Exception:  # written to half when it was killed, or damaged: begun anew
            self._storage.unlink(missing_ok=True)
            return []
        if known is None:
            self._storage.unlink(missing_ok=True)
            return []
        if known != self._key:
            raise ResultError(
                self._storage,
                f"{self._storage.parent.parent} holds candidates of another experiment, URDF or version, which are not "
                f"reused; {flag_words('force')} replaces them, {option_words('out')} writes elsewhere",
            )
        found = []
        for number, trial in enumerate(trials):
            told = trial.user_attrs
            if told.get("number") != number:
                break
            score = Score(**{name: told[name] for name in _SCORED})
            found.append(Candidate(number, trial.params, told["setting"], score, told["chosen"]))
        return found

    def _store(self, found: Sequence[Candidate], new: Sequence[Candidate]) -> None:
        """Add a batch to the journal, or write it anew where what it holds is not what goes before the batch."""
        if self._storage is None:
            return
        before, fresh = len(found) - len(new), not self._storage.is_file()
        if not fresh:
            fresh = len(self._journal(self._storage, new=False).get_trials(deepcopy=False)) != before
        if not fresh:
            self._journal(self._storage, new=False).add_trials([_frozen(item, self._space) for item in new])
            return
        beside = self._storage.with_suffix(".new")
        beside.unlink(missing_ok=True)
        study = self._journal(beside, new=True)
        study.set_user_attr("key", self._key)
        study.add_trials([_frozen(item, self._space) for item in found])
        os.replace(beside, self._storage)

    def _journal(self, path: Path, *, new: bool) -> Any:
        import optuna
        from optuna.storages.journal import JournalFileBackend, JournalFileOpenLock

        Path(f"{path}.lock").unlink(missing_ok=True)  # a killed run leaves it; nobody else writes into this folder
        lock = JournalFileOpenLock(str(path))
        storage = optuna.storages.JournalStorage(JournalFileBackend(str(path), lock_obj=lock))
        if new:
            return optuna.create_study(storage=storage, study_name=self._space.label)
        return optuna.load_study(storage=storage, study_name=self._space.label)


def best(candidates: Sequence[Candidate]) -> Candidate:
    """The candidate that wins: within the limits and with the least error; else with the least excess."""
    return min((item for item in candidates if item.chosen), key=lambda item: (item.score.rank, item.number))


def _frozen(item: Candidate, space: SearchSpace) -> Any:
    """A candidate as a trial of Optuna that is complete."""
    import optuna

    ranges = space.ranges if item.factors else {}
    return optuna.create_trial(
        params=dict(item.factors),
        distributions={
            name: optuna.distributions.FloatDistribution(low, high, log=True) for name, (low, high) in ranges.items()
        },
        value=item.score.value if not math.isnan(item.score.value) else math.inf,
        user_attrs={
            "number": item.number,
            "setting": dict(item.setting),
            "chosen": item.chosen,
            **{name: getattr(item.score, name) for name in _SCORED},
        },
    )
