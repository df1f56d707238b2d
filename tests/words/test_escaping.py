"""Names that other people chose are shown as they are, in a terminal, a page, a table, a paper and a figure."""

from __future__ import annotations

import json
import re
import unicodedata
from contextlib import nullcontext
from html.parser import HTMLParser

import pytest
from markdown_it import MarkdownIt
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from asmc_pin.cli import main
from asmc_pin.disk.resources import shipped
from asmc_pin.words.media import for_cell, for_figure, for_html, for_latex, for_markdown
from asmc_pin.words.text import message_text, printable, visible

NAMES = [
    "shoulder_pan_joint",
    "[/joint_1]",
    "[red]x[/red] :smile:",
    "<b>bold</b> & <script>alert(1)</script>",
    "a|b||c",
    "_a_ __b__ c_d",
    "*a* **b** a*b",
    "`code` ``",
    "100% $x$ $y",
    "\\ \\_ \\alpha \\\\",
    "[link](http://x) ![i](j) [a][b] <http://x>",
    "# heading",
    "> quoted",
    "1. item",
    "- item",
    "+",
    "&amp; &#60; R&D",
    "~~gone~~ ^up^ {x}",
    "--- --",
    "\"quoted\" 'single'",
    "Schlüssel 手 ‖M̄‖ ≤ 1",
]
STEERING = ["a\nb", "a\r\nb", "\x1b[31mred", "\x9b31m", "a\u202eb", "a\u2028b", "tab\tb", "\x00"]


def rendered(markdown: str) -> str:
    """The text that a reader sees; only text, no element of any kind, or None."""
    (opening, inline, closing) = MarkdownIt("commonmark").enable(["table", "strikethrough"]).parse(markdown)
    assert (opening.type, closing.type) == ("paragraph_open", "paragraph_close")
    kinds = {child.type for child in inline.children}
    assert kinds <= {"text", "text_special"}, kinds
    return "".join(child.content for child in inline.children)


@pytest.mark.parametrize("name", NAMES)
def test_markdown_shows_a_name_as_it_is(name):
    assert rendered(for_markdown(name)) == name
    assert rendered(f"before {for_markdown(name)} after") == f"before {name} after"


@pytest.mark.parametrize("name", NAMES)
def test_a_cell_shows_a_name_as_it_is_and_stays_one_cell(name):
    parser = MarkdownIt("commonmark").enable(["table", "strikethrough"])
    tokens = parser.parse(f"| {for_cell(name)} | b |\n| --- | --- |\n| {for_cell(name)} | 1 |")
    cells = [token.children for token in tokens if token.type == "inline"]
    assert len(cells) == 4
    for cell in cells[::2]:
        assert "".join(child.content for child in cell) == name
        assert {child.type for child in cell} <= {"text", "text_special"}


@pytest.mark.parametrize(
    "name", ["‖I − M⁻¹M̄‖₂ < 1 [rad/s²]", "shoulder_pan_joint", "a_b: 1 > 0, q̈_d + K_s", "-0.5", "Γ* is"]
)
def test_markdown_leaves_alone_what_means_nothing_in_it(name):
    assert for_markdown(name) == name


class Seen(HTMLParser):
    def __init__(self, page: str) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.text = ""
        self.attributes: list[str | None] = []
        self.feed(page)
        self.close()

    def handle_starttag(self, tag, attributes):
        self.tags.append(tag)
        self.attributes += [value for _, value in attributes]

    def handle_data(self, data):
        self.text += data


@pytest.mark.parametrize("name", NAMES)
def test_html_shows_a_name_as_it_is_in_text_and_in_an_attribute(name):
    seen = Seen(f'<p title="{for_html(name)}">{for_html(name)}</p>')
    assert (seen.tags, seen.text, seen.attributes) == (["p"], name, [name])


@pytest.mark.parametrize("name", NAMES)
def test_latex_has_no_command_and_no_row_of_a_name_s_own(name):
    text = for_latex(name)
    rest = re.sub(r"\\text(backslash|asciitilde|asciicircum|less|greater|bar|asciigrave)\{\}", "", text)
    rest = re.sub(r"\\[&%$#_{},]|\$[-^2\\a-z]+\$|\{\}|\{[\[*]\}", "", rest)
    assert not set(rest) & set("\\&%$#_{}~^<>|`")
    assert not text.startswith(("[", "*"))  # after the end of a row it would be an option of it


@pytest.mark.parametrize("name", NAMES)
def test_a_figure_draws_a_name_and_no_formula(name):
    figure = Figure()
    FigureCanvasAgg(figure)
    axes = figure.subplots()
    (line,) = axes.plot([0, 1], label=for_figure(name))
    axes.set_title(f"{for_figure(name)}\n" + r"$\tau_{1}$")
    legend = figure.legend(handles=[line])
    with pytest.warns(UserWarning, match="Glyph") if "手" in name else nullcontext():
        figure.draw_without_rendering()
    assert len(legend.get_texts()) == 1
    if not name.startswith("_"):
        assert legend.get_texts()[0].get_text().replace(r"\$", "$") == name


@pytest.mark.parametrize("name", STEERING)
@pytest.mark.parametrize("show", [printable, visible, for_html, for_markdown, for_cell, for_latex, for_figure])
def test_no_medium_is_steered_by_a_name(show, name):
    shown = show(name)
    kept = "\n\t" if show is for_html else ""  # white space there
    assert not [c for c in shown if unicodedata.category(c)[0] in "CZ" and c not in f" {kept}"]


def test_a_name_of_100_kb_has_an_end():
    assert len(printable("x" * 100_000)) < 250
    assert len(for_figure("x" * 100_000)) < 250


# Through the whole tool -----------------------------------------------------------------------------------------------

JOINT = "[/joint_1] <i>$q$</i> a|b"
LABELS = ["[/x] <b>B</b> | a_b & 100% $x$ *y* `z` \\ #", "_under_", ":smile: [red] &amp;"]


@pytest.fixture(scope="module")
def urdf(tmp_path_factory):
    path = tmp_path_factory.mktemp("arm") / "two_link.urdf"
    text = (shipped("urdf") / "two_link" / "two_link.urdf").read_text(encoding="utf-8")
    assert '"joint_1"' in text
    path.write_text(text.replace('"joint_1"', f'"{for_html(JOINT)}"'), encoding="utf-8")
    return path


def told(capfd, *arguments: str) -> tuple[int, str, str]:
    with pytest.raises(SystemExit) as end:
        main(list(arguments))
    out, err = capfd.readouterr()
    return end.value.code, out, err


@pytest.mark.parametrize(
    "arguments",
    [
        ("verify", "URDF", "--mbar", "0.01", "--samples", "64"),
        ("design", "URDF"),
        ("stability", "URDF", "--mbar", "0.01", "--ks", "5", "--beta", "5", "--period", "0.001"),
        ("agree", "URDF"),
        ("verify", "URDF", "--mbar", "0.01", "--box", "nosuch=0:1"),
    ],
    ids=lambda arguments: arguments[0],
)
def test_a_terminal_shows_a_joint_s_name_as_it_is(capfd, urdf, arguments):
    status, out, err = told(capfd, *(str(urdf) if word == "URDF" else word for word in arguments))
    assert status in (0, 2), err
    assert JOINT in (out if arguments[0] == "verify" and status == 0 else out + err)
    assert "\\[" not in out + err


@pytest.fixture(scope="module")
def result(urdf, tmp_path_factory):
    from asmc_pin.experiment import Experiment
    from asmc_pin.study import compare

    data = {
        "name": "hostile",
        "arm": str(urdf),
        "period": 0.002,
        "duration": 0.1,
        "ensemble": {"trials": 1},
        "reference": {"kind": "quintic", "start": [0.3, 0.2], "targets": [[0.35, 0.15]], "move": 0.1},
        "defaults": {"mbar": [0.05, 0.02], "beta": 8.0},
        "controllers": {label: {"law": "ppc", "ks": 5.0 + k} for k, label in enumerate(LABELS)},
    }
    return compare(Experiment.from_dict(data), out=tmp_path_factory.mktemp("hostile") / "result")


def test_a_report_shows_labels_and_joints_once_escaped(result):
    page = (result.out / "report.html").read_text(encoding="utf-8")
    assert f"<title>{for_html('hostile: ' + ' · '.join(LABELS))}</title>" in page
    body = re.sub(r"<script.*?</script>|<style.*?</style>", "", page, flags=re.DOTALL)
    seen = Seen(body)
    for name in (JOINT, *LABELS):
        assert name in seen.text
    assert "&lt;" not in seen.text
    assert "&amp;amp;lt;" not in body
    assert not {"b", "i"} & set(re.findall(r"<(b|i)>[BQq$]", body))


def test_a_summary_shows_labels_and_joints_in_markdown_and_latex(result):
    markdown = (result.out / "summary.md").read_text(encoding="utf-8")
    tokens = MarkdownIt("commonmark").enable("table").parse(markdown)
    assert not [token for token in tokens if token.type == "html_block"]
    cells = ["".join(child.content for child in token.children) for token in tokens if token.type == "inline"]
    for name in (JOINT, *LABELS):
        assert name in cells
    latex = (result.out / "summary.tex").read_text(encoding="utf-8")
    for name in (JOINT, *LABELS):
        assert for_latex(name).removeprefix("{[}") in latex


def test_a_terminal_and_json_show_labels_as_they_are(result, capsys):
    from asmc_pin.cli.commands.study_commands import print_comparison
    from asmc_pin.cli.console import print_json

    print_comparison(result)
    out = capsys.readouterr().out
    for label in LABELS:
        assert any(line.startswith(label) for line in out.splitlines())
    print_json(result.to_json_dict())
    assert list(json.loads(capsys.readouterr().out)["controllers"]) == LABELS


def test_json_keeps_a_name_and_steers_no_terminal(capsys):
    from asmc_pin.cli.console import print_json

    print_json({"names": STEERING})
    out = capsys.readouterr().out
    assert json.loads(out)["names"] == STEERING
    assert not [c for c in out if unicodedata.category(c)[0] in "CZ" and c not in " \n"]


def test_a_progress_bar_shows_a_label_as_it_is(monkeypatch, capsys):
    from asmc_pin.cli.console import progress_bar

    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setenv("TTY_COMPATIBLE", "1")
    with progress_bar() as show:
        for label in (*LABELS, "[/joint_1]"):
            show(label, 0.5)
    assert "[/joint_1]" in capsys.readouterr().err


def test_what_is_shown_is_short_also_where_each_sign_becomes_a_code():
    assert len(printable("\0" * 10_000)) < 250
    assert len(message_text("5" + "\0" * 10_000)) < 2100
    assert printable("\0") == "\\x00"
