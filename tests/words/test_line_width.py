"""Prose of generated Markdown is wrapped, and means the same as before."""

import pytest

from asmc_pin.words.line_width import WIDTH, wrap_prose

LONG = "a sentence with some words in it " * 12


def test_a_long_paragraph_gets_lines_that_fit_and_keeps_its_words():
    wrapped = wrap_prose(LONG.strip())
    assert max(map(len, wrapped.split("\n"))) <= WIDTH
    assert wrapped.split() == LONG.split()


def test_an_item_of_a_list_stays_one_item():
    first, *others = wrap_prose("- " + LONG.strip()).split("\n")
    assert first.startswith("- a")
    assert others
    assert all(line.startswith("  ") and line[2] != " " for line in others)


@pytest.mark.parametrize("kept", ["| " + LONG, "# " + LONG, "    " + LONG, "![" + LONG + "](a.png)", "short"])
def test_what_is_no_prose_or_fits_stays(kept):
    assert wrap_prose(kept) == kept


def test_code_between_fences_stays_and_prose_after_it_does_not():
    code = f"```\n{LONG}\n```"
    assert wrap_prose(code) == code
    assert wrap_prose(f"{code}\n{LONG}").startswith(f"{code}\na sentence")
    assert len(wrap_prose(f"{code}\n{LONG}").split("\n")) > 4


@pytest.mark.parametrize("mark", ["+", "-", "*", "1.", "2)", "#", ">"])
@pytest.mark.parametrize("before", range(100, 125))
def test_no_sign_within_a_sentence_begins_a_line(mark, before):
    wrapped = wrap_prose("x" * (before // 2) + " " + "y" * (before - before // 2 - 1) + f" {mark} z " + LONG.strip())
    assert not any(line.startswith(mark) for line in wrapped.split("\n"))
    assert f" {mark}" in wrapped
