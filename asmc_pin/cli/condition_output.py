"""What a command on the condition gives back: its status, its text and its page."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from asmc_pin.cli.console import note, rich_console
from asmc_pin.words.text import visible

if TYPE_CHECKING:
    from asmc_pin.arms import Arm
    from asmc_pin.condition import ConditionReport, DesignReport

EXIT = {"holds": 0, "unrefuted": 0, "violated": 1, "undecided": 3}
"""Exit status of each verdict."""


def print_verdict(report: ConditionReport) -> None:
    """Print a report of the condition for a person to read: what it is about first; angles in degrees too."""
    from rich.table import Column, Table
    from rich.text import Text

    console = rich_console()

    def tell(line: str, style: str = "") -> None:
        console.print(Text(visible(line), style), soft_wrap=True)

    style = {"holds": "bold green", "unrefuted": "bold green", "violated": "bold red"}.get(
        report.verdict, "bold yellow"
    )
    for line in report.lines():
        tell(line, style if line == report.headline() else "")
    header, rows = report.table()
    table = Table(Column(header[0], overflow="fold"), *header[1:], box=None, pad_edge=False)
    for row in rows:
        table.add_row(*row)
    console.print(table)
    for line in report.remarks():
        tell(line)


def write_page(report: ConditionReport | DesignReport, arm: Arm, page: Path | None) -> None:
    """``--report FILE``, if it was asked for."""
    if page is not None:
        from asmc_pin.pages.condition_page import write_condition_report

        write_condition_report(report, arm, page)
        note(f"report: {page}")
