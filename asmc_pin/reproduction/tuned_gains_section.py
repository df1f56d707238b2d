"""The section on tuned gains of the page of the reproduction."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from asmc_pin.pages.tables.text_table import Table, number
from asmc_pin.reproduction.joint_figures import text_table
from asmc_pin.reproduction.printed_tables import TUNED_SUFFIX


def tuned_gains(data: Mapping[str, Any]) -> Iterator[str]:
    """How the gains were found, what each law was tuned to, and which ε the existing law has."""
    yield (
        f"Found by `{data['command']}`: one Optuna study (TPE) for each law, with the same number of trials and the "
        "same seed. The objective is the "
        "geometric mean over the joints of the RMS error; a torque variation above that of the proposed law with the "
        "gains of the file counts by the square "
        "of the excess. The files say the objective with its numbers, its value before and after, and the ranges."
    )
    yield ""
    rows = [
        [f"Table {item['table']}, {item['set']}", label.removesuffix(TUNED_SUFFIX), _gains_text(values)]
        for item in data["experiments"].values()
        for label, values in item["tuned"].items()
    ]
    yield text_table(Table("", ["experiment", "law", "tuned to"], rows))
    yield ""
    yield _epsilons(data)
    yield ""


def _epsilons(data: Mapping[str, Any]) -> str:
    """Which ε the existing law was run with: its authors tune it by the gain, Baek 2016 does not say."""
    used = [
        (label, value) for item in data["experiments"].values() for label, value in item["existing_epsilon"].items()
    ]
    by_gain = [label for label, value in used if value == "4KL"]
    constant = sorted({float(value) for _, value in used if value != "4KL"})
    parts = [f'ε of the existing law: its authors advise 4 k̂ L (`epsilon = "4KL"`), which {len(by_gain)} rows use']
    if constant:
        parts.append(
            f"{len(used) - len(by_gain)} rows use a constant, {number(constant[0])} to {number(constant[-1])} rad/s, "
            "as written in their files"
        )
    return "; ".join(parts) + "."


def _gains_text(values: Mapping[str, Any]) -> str:
    return ", ".join(f"{name} = {value}" for name, value in values.items())
