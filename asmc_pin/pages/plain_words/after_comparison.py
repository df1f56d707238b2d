"""What to do after a comparison: the one command that follows from it, for the terminal and the report alike."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from typing import NamedTuple

from asmc_pin.experiment import Experiment
from asmc_pin.experiment.arm_words import arm_words, mbar_words


class NextStep(NamedTuple):
    """A command and what it is for."""

    what: str
    command: str


def after_comparison(experiment: Experiment, verdicts: Mapping[str, str], folder: str) -> NextStep:
    """The next step: mend an M̄ that breaks its condition, else prove it, else look at the motion.

    Args:
        experiment: As run.
        verdicts: Of Lemma 1's condition along the motion, by label as in the file: ``violated`` or anything else.
        folder: Of the result.
    """
    with_mbar = {label: words for label in verdicts if (words := mbar_words(experiment, label))}
    for label in with_mbar:
        if verdicts[label] == "violated":
            return NextStep(f"find an M̄ that is allowed, for {label}", _command("design", arm_words(experiment)))
    for label, words in with_mbar.items():
        about = f"prove that the M̄ of {label} is allowed at all angles of the joints, or find where it is not"
        return NextStep(about, _command("verify", [*arm_words(experiment), *words, "--certify"]))
    return NextStep("watch the motion", _command("view", [folder]))


def _command(verb: str, words: list[str]) -> str:
    return shlex.join(["asmc-pin", verb, *words])
