"""Every command and snippet that README.md and docs/ show is run, and prints what the page shows."""

from __future__ import annotations

import re

import pytest
from shown_blocks import ELSEWHERE, LANGUAGES, ROOT, Block, Reader, blocks, commands, differs, pages

from asmc_pin.cli.dispatch import app

SHOWN = {page: list(blocks(page)) for page in pages()}


def shown(text: str, language: str = "console", **said: str) -> Block:
    return Block("page.md", 1, language, text, said)


@pytest.mark.long
@pytest.mark.parametrize("page", [page for page, found in SHOWN.items() if any(b.language in LANGUAGES for b in found)])
def test_a_reader_who_follows_a_page_gets_what_it_shows(page, tmp_path, monkeypatch):
    monkeypatch.setenv("MPLBACKEND", "Agg")
    reader = Reader(tmp_path)
    for block in SHOWN[page]:
        for command, below, printed in reader.run(block):
            if block.language == "console" and "run instead" not in block.said:
                told = differs(below, printed, block.said.get("varies"))
                assert not told, f"{page}:{block.line}: {command}\n{told}"
    run = "\n".join(block.text for block in SHOWN[page])
    prefix = f"{page.removeprefix('docs/').removesuffix('.md')}_"  # such pictures the page makes, if it names them
    for name in re.findall(rf"\]\(images/({prefix}[\w.-]+)\)", (ROOT / page).read_text(encoding="utf-8")):
        if name not in run:
            continue  # a benchmark or a script of docs/ draws it
        assert (tmp_path / name).stat().st_size > 1000, f"the page shows {name}, which its commands do not make"


@pytest.mark.parametrize("page", SHOWN)
def test_a_command_stands_in_a_block_that_is_run(page):
    for block in SHOWN[page]:
        if block.language not in LANGUAGES:
            told = f"{page}:{block.line} shows a command in a block of '{block.language}'; call it sh or console"
            assert not re.search(r"^(\$ )?(asmc-pin|make|pip|python) ", block.text, re.MULTILINE), told


def test_few_blocks_are_not_run_and_each_says_why():
    kept = [block for found in SHOWN.values() for block in found if "not run" in block.said]
    assert len(kept) <= 18
    assert all(len(block.said["not run"]) > 10 for block in kept)


def test_a_page_that_is_not_followed_here_is_followed_elsewhere():
    for page, test in ELSEWHERE.items():
        assert (ROOT / page).name in (ROOT / test).read_text(encoding="utf-8")


INLINE = [
    (page, words)
    for page in SHOWN
    for words in re.findall(r"(?<!`)`asmc-pin ([^`]+)`", (ROOT / page).read_text(encoding="utf-8"))
]


@pytest.mark.parametrize(("page", "words"), sorted(set(INLINE)))
def test_a_command_within_a_sentence_is_one_that_there_is(page, words):
    import typer

    group = typer.main.get_command(app)
    command, *rest = words.split()
    if command.startswith("-") or command in ("COMMAND", "…"):
        return
    known = {option for each in group.get_command(None, command).params for option in each.opts}
    given = {word.split("=")[0] for word in rest if re.fullmatch(r"--[a-z][\w-]*(=.*)?", word)}
    assert given <= known | {"--help"}, f"{page}: asmc-pin {words}"


# The means themselves -------------------------------------------------------------------------------------------------


def test_words_are_compared_exactly_numbers_nearly_and_times_not_at_all():
    line = "norm 0.362 found (sampled, 65000 configurations, 2.9 s)\n"
    assert differs(line, "norm 0.3625 found (sampled, 12 configurations, 31.5 s)\n") is None
    assert differs(line, line.replace("norm", "number"))
    assert differs(line, line.replace("0.362", "0.38"))
    assert differs(line, line + "next: nothing\n")
    assert differs(line + "at 1\n", "at 2\nat 3\n" + line, "at ") is None
    assert differs(line + "at 1\n", line, "at ")
    assert differs(line + "at 1\n", "at 2\n", "at ")
    assert differs(line + "at 1\nin 1\n", line + "at 2\n", "at | in")


def test_a_console_is_taken_apart():
    block = shown("$ one \\\n  --more\nprints\n\n$ two\n")
    assert commands(block) == [("one \\\n  --more", "prints\n\n"), ("two", "")]
    assert commands(shown("a=1   # why\n\n# nothing\nb \\\n c\n", "sh")) == [("a=1   # why", ""), ("b   c", "")]


def test_a_reader_keeps_variables_files_and_names_and_stops_where_a_command_fails(tmp_path):
    reader = Reader(tmp_path)
    reader.run(shown("X=5\n", "sh"))
    assert reader.run(shown("$ echo $X\n6\n")) == [("echo $X", "6\n", "5\n")]
    reader.run(shown("a = 1\n", "toml", file="in/a.toml"))
    reader.run(shown("from pathlib import Path\nthere = Path('in/a.toml').read_text()\n", "python"))
    reader.run(shown("assert there == 'a = 1\\n'\n", "python"))
    reader.run(shown("exit 1\n", "sh", **{"not run": "it fails"}))
    reader.run(shown("exit 1\ntrue\n", "sh", **{"ends with": "1 0"}))
    with pytest.raises(AssertionError, match="ended with 1"):
        reader.run(shown("false\n", "sh"))
