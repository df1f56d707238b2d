"""The parts of the reference that are lists of all there is: every public name, and every command with its options."""

from __future__ import annotations

from itertools import groupby

import typer
from derived_parts import code, part, prose, table
from import_graph import PACKAGE, docstring
from public_names import by_room, first_line

from asmc_pin.cli.app import PANELS
from asmc_pin.cli.dispatch import app
from asmc_pin.cli.examples import EXAMPLES
from asmc_pin.words.media import for_cell


@part("public-names")
def public_names() -> str:
    """docs/python.md: what a user may import, room by room; on the site each name leads to its page."""
    sections = []
    for room, names in by_room().items():
        said = docstring(f"{PACKAGE.name}.{room}")[0]
        rows = [[f"`asmc_pin.{name}`", prose(first_line(name))] for name in names]
        sections.append(f"## {room}\n\n{prose(said)}\n\n{table(['name', 'what it is'], rows)}")
    return "\n\n".join(sections)


@part("commands")
def commands() -> str:
    """docs/commands.md: every command as its own help has it, arguments first."""
    group = typer.main.get_command(app)
    found = [group.get_command(None, name) for name in sorted(group.list_commands(None))]
    found.sort(key=lambda each: PANELS.index(each.rich_help_panel))
    sections = []
    for question, members in groupby(found, key=lambda each: each.rich_help_panel):
        sections.append(f"## {question}")
        sections += [_command(each) for each in members]
    return "\n\n".join(sections)


def _command(command: typer.core.TyperCommand) -> str:
    context = command.make_context(command.name, [], resilient_parsing=True)
    records = (parameter.get_help_record(context) for parameter in command.params)
    rows = [
        [code(shown.replace(" range>", ">").replace("|", r"\|")), for_cell(said)]
        for shown, said in filter(None, records)
    ]
    arguments = " ".join(p.metavar or p.name.upper() for p in command.params if p.param_type_name == "argument")
    said = [for_cell(paragraph) for paragraph in command.help.split("\n\n")]
    lines = "\n".join(f"asmc-pin {line}" for line in EXAMPLES.get(command.name, ()))
    return "\n\n".join(
        [
            f"### {command.name}",
            f"`asmc-pin {command.name} {arguments}".rstrip() + "`",
            *said,
            *([table(["argument or option", "meaning"], rows)] if rows else []),
            *([f"```text\n{lines}\n```"] if lines else []),
        ]
    )
