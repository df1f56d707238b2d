"""Tuned rows of the paper's experiments: the three adaptive and switching laws, same budget, same limit of chatter.

They stand in the experiment files between two marks, with the command that wrote them. Tuning anew writes such files
into a folder of the user's; the shipped ones are part of the package, and only a hand puts others in their place.
"""

from __future__ import annotations

import re
from pathlib import Path

from asmc_pin.disk.files import write_whole
from asmc_pin.disk.resources import shipped
from asmc_pin.engine import rollout
from asmc_pin.experiment import Experiment
from asmc_pin.experiment.toml_text import write_toml
from asmc_pin.metrics import METRICS
from asmc_pin.reproduction.printed_tables import PROPOSED, TUNED_SUFFIX
from asmc_pin.study.law_study import own_parameters
from asmc_pin.study.tuning import Progress, Tuning, tune_own_gains
from asmc_pin.study.tuning_objective import Objective

COMMAND = "asmc-pin reproduce --tune"
_BEGIN, _END = "# begin tuned", "# end tuned"
_BLOCK = re.compile(rf"\n*^{_BEGIN}.*?^{_END}\n?", re.MULTILINE | re.DOTALL)


def untuned(experiment: Experiment) -> dict[str, dict[str, object]]:
    """The controllers' tables without the tuned rows."""
    return {label: table for label, table in experiment.controllers.items() if not label.endswith(TUNED_SUFFIX)}


def tune_rows(experiment: Experiment, progress: Progress | None = None) -> Tuning:
    """Tune every law of an experiment that has gains of its own, none allowed more chatter than the proposed law has.

    The limit is the torque variation of the proposed law with the gains of the file, joint by joint.
    """
    plain = experiment.replace(controllers=untuned(experiment))
    law = plain.build_controllers()[PROPOSED]
    run = rollout(plain.build_plant(), law, plain.build_reference(), plain.duration)
    limit = tuple(float(f"{x:.4g}") for x in METRICS["torque_variation"](run)[0])
    labels = [label for label in plain.controllers if own_parameters(plain, label)]
    return tune_own_gains(plain, labels, objective=Objective(limit), progress=progress)


def write_tuned(tuning: Tuning, folder: Path) -> Path:
    """Write the file of a shipped experiment with the tuned rows in the place of its own.

    Args:
        tuning: Of the experiment.
        folder: Where to; made if need be.

    Returns:
        Path of the file.
    """
    name = f"{tuning.experiment.name}.toml"
    text = _BLOCK.sub("\n", (shipped("experiments") / name).read_text(encoding="utf-8")).rstrip("\n") + "\n"
    folder.mkdir(parents=True, exist_ok=True)
    write_whole(folder / name, text + "\n" + block(tuning))
    return folder / name


def block(tuning: Tuning) -> str:
    """The rows as TOML, with how they were found."""
    head = [
        f"{_BEGIN}: {COMMAND} {tuning.experiment.name}",
        f"# Objective: {tuning.objective.text}.",
        f"# {tuning.trials} trials for each law, parameters within a factor of {tuning.span:g}, seed {tuning.seed}.",
    ]
    tables = tuning.tuned().controllers
    rows = []
    for label, law in tuning.laws.items():
        rows.append(f"# Objective of {label}: {law.untuned:.4g} untuned, {law.value:.4g} tuned.")
        rows.append(write_toml({"controllers": {label + TUNED_SUFFIX: tables[label]}}).strip("\n"))
        rows.append("")
    return "\n".join([*head, "", *rows[:-1], _END, ""])
