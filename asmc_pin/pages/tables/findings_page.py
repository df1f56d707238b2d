"""A page of findings: a title, facts, tables under headings, figures; the same in Markdown and in one HTML file.

Nothing in it depends on when or where it was made.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from asmc_pin.disk.files import write_whole
from asmc_pin.experiment import Experiment
from asmc_pin.experiment.toml_text import toml_value
from asmc_pin.pages.figure_style import paper_style, save
from asmc_pin.pages.html_fragments import details, scroll, table_html
from asmc_pin.pages.plates import Plate, framed, is_html, write_beside
from asmc_pin.pages.tables.text_table import Table, markdown_table
from asmc_pin.words.media import for_html, for_markdown

SUMMARY, REPORT = "summary.md", "report.html"
"""The files of a page in the folder of what it is about."""


@dataclass(frozen=True, eq=False)
class Section:
    """Tables under a heading.

    Attributes:
        title: The heading.
        how: How they are to be read.
        tables: Each under its own title, where `named`.
        named: Whether there may be several, so that each says what it is of.
    """

    title: str
    how: str
    tables: Sequence[Table]
    named: bool = False


@dataclass(frozen=True, eq=False)
class FindingsPage:
    """What stands on the page.

    Attributes:
        title: Of all.
        facts: Lines under it.
        sections: Tables.
        plates: Figures.
        colours: Of the controllers, beside their names in the HTML tables.
        appendix: HTML at the end, of the HTML page alone.
    """

    title: str
    facts: Sequence[str]
    sections: Sequence[Section]
    plates: Sequence[Plate]
    colours: Mapping[str, str] = field(default_factory=dict)
    appendix: str = ""

    def markdown(self, figures: str) -> str:
        """The page as Markdown; `figures` stands before the name of a figure's PNG file, from the page's own folder."""
        lines = [f"# {for_markdown(self.title)}", "", *(f"- {for_markdown(fact)}" for fact in self.facts)]
        for section in self.sections:
            lines += ["", f"## {section.title}", "", for_markdown(section.how)]
            for table in section.tables:
                lines += ["", f"{for_markdown(_name(table))}:"] if section.named else []
                lines += ["", markdown_table(table)]
        for plate in self.plates:
            lines += plate.markdown(figures)
        return "\n".join(lines) + "\n"

    def html(self) -> str:
        """The page as one HTML file that opens offline."""
        facts = (f"<li>{for_html(fact)}</li>" for fact in self.facts)
        body = [f"<h1>{for_html(self.title)}</h1>", "<ul>", *facts, "</ul>"]
        for section in self.sections:
            body += [f"<h2>{section.title}</h2>", f'<p class="soft">{for_html(section.how)}</p>']
            for table in section.tables:
                body += [f"<h3>{for_html(_name(table))}</h3>"] if section.named else []
                body.append(
                    scroll(
                        f"{section.title}: {_name(table)}" if section.named else section.title,
                        table_html(table, self.colours),
                    )
                )
        body += ["<h2>Figures</h2>", *(plate.html() for plate in self.plates)]
        return framed(self.title, [*body, self.appendix] if self.appendix else body, player=False)

    def write_into(self, folder: Path) -> None:
        """Write it into the folder of what it is about: its figures as PDF and PNG, `SUMMARY` and `REPORT`.

        Raises:
            ResultError: a file cannot be written.
        """
        figures = folder / "figures"
        figures.mkdir(exist_ok=True)
        with paper_style():
            for plate in self.plates:
                save(plate.figure, figures / plate.name)
        write_whole(folder / SUMMARY, self.markdown("figures/"))
        write_whole(folder / REPORT, self.html())

    def write(self, path: str | Path) -> None:
        """Write it elsewhere than into the folder of what it is about.

        Args:
            path: Ends in ``.html`` (one file) or in ``.md`` (figures as PNG files beside it).

        Raises:
            ParameterError: another suffix.
            ResultError: the file cannot be written.
        """
        path = Path(path)
        if is_html(path):
            write_whole(path, self.html())
            return
        write_beside(path, self.plates)
        write_whole(path, self.markdown(f"{path.stem}_"))


def _name(table: Table) -> str:
    return table.title or "one point"


def experiment_lines(experiment: Experiment) -> Iterator[str]:
    """What was run, and what varied from trial to trial."""
    yield (
        f"{experiment.duration:g} s on {experiment.arm.source}, control period {1e3 * experiment.period:g} ms, "
        f"seed {experiment.seed}"
    )
    for axis, given in experiment.sweep.items():
        yield f"varies: {toml_value(axis)} = {toml_value(given)}"


def experiment_details(summary: str, toml: str) -> str:
    """An experiment to unfold, for the end of a page."""
    return details(
        summary, f'<pre role="region" aria-label="{for_html(summary)}" tabindex="0">{for_html(toml.strip())}</pre>'
    )
