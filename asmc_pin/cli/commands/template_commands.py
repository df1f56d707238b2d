"""`asmc-pin experiments` and `asmc-pin new`: the experiments that are shipped, and a copy of one to change."""

from __future__ import annotations

import re
import shlex
from pathlib import Path
from typing import Annotated, Any

import typer

from asmc_pin.cli.app import LISTS, STUDIES, app
from asmc_pin.cli.console import print_json, rich_console, say
from asmc_pin.cli.next_step import say_next
from asmc_pin.cli.options import JsonOption
from asmc_pin.disk.file_access import check_writable
from asmc_pin.disk.files import write_whole
from asmc_pin.errors import ExperimentError, ParameterError
from asmc_pin.words.nearest_name import nearest

_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]*")


def experiment_table() -> list[dict[str, Any]]:
    """The shipped experiments: name, arm, controllers, seconds, and what each is about in its own first words."""
    from asmc_pin.experiment.finding import experiment_names, find_experiment
    from asmc_pin.experiment.toml_text import read_toml

    rows = []
    for name in experiment_names():
        text, data = read_toml(find_experiment(name))
        arm = data["arm"]
        rows.append(
            {
                "name": name,
                "arm": arm if isinstance(arm, str) else arm["source"],
                "controllers": list(data["controllers"]),
                "duration": float(data["duration"]),
                "about": _first_sentence(text),
            }
        )
    return rows


def _first_sentence(text: str) -> str:
    comment = []
    for line in text.splitlines():
        if line.startswith("#:"):
            continue
        if not line.startswith("# "):
            break
        comment.append(line[2:].strip())
    return re.split(r"(?<=[.:]) ", " ".join(comment))[0].rstrip(".:")


@app.command(rich_help_panel=LISTS)
def experiments(as_json: JsonOption = False) -> None:
    """List the experiments that are shipped: run one by its name, or copy it with 'asmc-pin new'."""
    rows = experiment_table()
    if as_json:
        print_json({"experiments": rows})
        return
    from rich.table import Table

    table = Table("name", "arm", "s", "about", box=None, pad_edge=False)
    table.columns[0].no_wrap = True
    for column in table.columns:
        column.overflow = "fold"
    for row in rows:
        table.add_row(row["name"], row["arm"], f"{row['duration']:g}", row["about"])
    rich_console().print(table)
    say_next("a copy to change", "asmc-pin new mine.toml --from demo")


@app.command(rich_help_panel=STUDIES)
def new(
    file: Annotated[str, typer.Argument(metavar="FILE", help="The experiment to write, ending in .toml.")],
    template: Annotated[
        str, typer.Option("--from", metavar="NAME", help="What to copy: see 'asmc-pin experiments'.")
    ] = "demo",
) -> None:
    """Copy a shipped experiment to a file of your own, to be changed and compared; never over a file that is there."""
    from asmc_pin.experiment.finding import experiment_names, find_experiment

    names = experiment_names()
    if template not in names:
        said = nearest(template, names, "shipped are")
        raise ParameterError("--from", f"there is no shipped experiment '{template}'; {said}")
    path = Path(file)
    if path.suffix != ".toml" or not _NAME.fullmatch(path.stem):
        raise ParameterError(
            "FILE", f"'{file}' given, a name of letters, digits, '.', '_' and '-' that ends in .toml expected"
        )
    if path.exists():
        raise ExperimentError("", f"{file} is there already, and nothing is written over it; choose another name")
    check_writable(path)
    text = find_experiment(template).read_text(encoding="utf-8")
    # Its results get a folder of their own; the schema lies beside the shipped files only.
    text = re.sub(r'^name = ".*"$', f'name = "{path.stem}"', text, count=1, flags=re.MULTILINE)
    text = re.sub(r"\A#:schema .*\n", "", text)
    write_whole(path, text)
    say(f"wrote {file}, a copy of {template}; change its arm, motion and controllers")
    say_next("run it", shlex.join(["asmc-pin", "compare", file]))
