"""The commands and snippets that the pages show, run as a reader would; with names of pages, their output is renewed.

Fenced blocks in `sh`, `console` and `python` are run in the order of a page, in one folder; `toml` is read. In
`console` a line after ``$ `` is a command and the lines below it are what it prints. What a reader sees nothing of
stands in a comment right above a block:

* ``<!-- file: NAME -->``: the block is that file.
* ``<!-- not run: WHY -->``: it cannot be: a placeholder, a network, hours.
* ``<!-- run instead: … -->``: a quick form of the same.
* ``<!-- before: … -->``: what a reader has by then, in the language of the block.
* ``<!-- ends with: 0 2 -->``: exit statuses of its commands, where not all are 0.
* ``<!-- varies: WORDS | WORDS -->``: how lines begin that differ from one processor to another, as which of many
  that are equally good a search meets. They are not compared, and some of each beginning have to be there.
"""

from __future__ import annotations

import argparse
import math
import os
import re
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Iterator
from contextlib import chdir
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
LANGUAGES = ("sh", "console", "python", "toml")
# Carried out by a test of its own, in a copy of the checkout.
ELSEWHERE = {"docs/extending.md": "tests/test_extending.py"}

_BLOCK = re.compile(r"((?:^<!--(?:(?!-->).)*-->\n+)*)^```([^\n]*)\n(.*?)^```$", re.DOTALL | re.MULTILINE)
_SAID = re.compile(r"<!-- (file|not run|run instead|before|ends with|varies): ?(.*?) ?-->", re.DOTALL)
_DERIVED = re.compile(r"<!-- begin ([\w-]+) -->.*?<!-- end \1 -->", re.DOTALL)
_COMMAND = re.compile(r"^\$ ((?:.*\\\n)*.*)\n?", re.MULTILINE)
_NUMBER = re.compile(r"(?<![\w.])[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")
# How long something took, and how much was looked at meanwhile.
_TIME = re.compile(r"(?:[\d.]+ s(?=\)|$)|\d+ configurations(?=, [\d.]+ s))", re.MULTILINE)


@dataclass(frozen=True)
class Block:
    """A fenced block of a page.

    Attributes:
        page: The page, from the top of the checkout.
        line: Where it begins.
        language: What stands after the fence.
        text: What is shown.
        said: What the comments above it say.
        span: Where `text` stands in the page.
    """

    page: str
    line: int
    language: str
    text: str
    said: dict[str, str] = field(default_factory=dict)
    span: tuple[int, int] = (0, 0)


def pages() -> list[str]:
    """Every page that may show something to run."""
    found = [ROOT / "README.md", *(ROOT / "docs").glob("*.md"), *(ROOT / "docs" / "howto").glob("*.md")]
    names = (path.relative_to(ROOT).as_posix() for path in found)
    return sorted(name for name in names if name not in ELSEWHERE)


def blocks(page: str) -> Iterator[Block]:
    """The blocks of a page, but for those in parts that are derived from the code."""
    text = (ROOT / page).read_text(encoding="utf-8")
    derived = [found.span() for found in _DERIVED.finditer(text)]
    for found in _BLOCK.finditer(text):
        if not any(start <= found.start() < end for start, end in derived):
            line = text.count("\n", 0, found.start(2)) + 1
            yield Block(page, line, found[2], found[3], dict(_SAID.findall(found[1])), found.span(3))


def commands(block: Block) -> list[tuple[str, str]]:
    """Commands of a block in `sh` or `console`, each with the output that is shown below it."""
    if block.language == "sh":
        lines = (line for line in block.text.replace("\\\n", " ").splitlines() if line.split("#")[0].strip())
        return [(line, "") for line in lines]
    found = list(_COMMAND.finditer(block.text))
    ends = [each.start() for each in found[1:]] + [len(block.text)]
    return [(each[1], block.text[each.end() : end]) for each, end in zip(found, ends, strict=True)]


def differs(shown: str, printed: str, varies: str | None = None) -> str | None:
    """What is not as shown: words have to be equal, numbers to two percent, and times are not looked at.

    Of lines that vary it is enough that there are some on both sides.
    """
    begins = () if varies is None else tuple(varies.split(" | "))
    for words in begins:
        if not all(any(line.startswith(words) for line in text.splitlines()) for text in (shown, printed)):
            return f"no line begins with {words!r} in what is shown, or in what is printed:\n{printed}"
    shown, printed = (
        "\n".join(line for line in text.splitlines() if not line.startswith(begins)) for text in (shown, printed)
    )
    for one, other in zip(_lines(shown), _lines(printed), strict=False):
        numbers = [[float(number) for number in _NUMBER.findall(line)] for line in (one, other)]
        same = _NUMBER.sub("#", one) == _NUMBER.sub("#", other)
        if not same or not all(map(_close, *numbers)):
            return f"shown:   {one}\nprinted: {other}"
    if len(_lines(shown)) != len(_lines(printed)):
        return f"shown are {len(_lines(shown))} lines, printed {len(_lines(printed))}:\n{printed}"
    return None


def _lines(text: str) -> list[str]:
    return [" ".join(line.split()) for line in _TIME.sub("…", text).splitlines() if line.strip()]


def _close(one: float, other: float) -> bool:
    return math.isclose(one, other, rel_tol=0.02, abs_tol=1e-9)


class Reader:
    """Somebody who follows a page from top to bottom in one folder."""

    def __init__(self, folder: Path) -> None:
        """Begin in a folder, with nothing defined."""
        self.folder = folder
        self.namespace: dict[str, object] = {"__name__": "__page__"}
        self.variables = ""

    def run(self, block: Block) -> list[tuple[str, str, str]]:
        """Do what a block shows.

        Returns:
            Of every command: itself, what is shown of it and what it printed.

        Raises:
            AssertionError: a command ends with another status than it should.
        """
        if "file" in block.said:
            (self.folder / block.said["file"]).parent.mkdir(parents=True, exist_ok=True)
            (self.folder / block.said["file"]).write_text(block.text, encoding="utf-8")
        elif "not run" in block.said:
            pass
        elif block.language == "toml":
            tomllib.loads(block.text)
        elif block.language == "python":
            code = block.said.get("before", "") + "\n" + block.said.get("run instead", block.text)
            with chdir(self.folder):
                exec(compile(code, f"{block.page}:{block.line}", "exec", dont_inherit=True), self.namespace)
        elif block.language in ("sh", "console"):
            return list(self._commands(block))
        return []

    def _commands(self, block: Block) -> Iterator[tuple[str, str, str]]:
        if "run instead" in block.said:
            block = Block(block.page, block.line, "sh", block.said["run instead"], block.said)
        if "before" in block.said:
            self._shell(block.said["before"])
        expected = iter(block.said.get("ends with", "").split())
        for command, shown in commands(block):
            done = self._shell(command)
            status = int(next(expected, "0"))
            where = f"{block.page}:{block.line}: {command}"
            assert done.returncode == status, f"{where}\nended with {done.returncode}\n{done.stdout}{done.stderr}"
            if re.fullmatch(r"\w+=\S*", command.split("#")[0].strip()):
                self.variables += command + "\n"
            yield command, shown, done.stderr if status == 2 else done.stdout

    def _shell(self, command: str) -> subprocess.CompletedProcess[str]:
        """Run a command with the interpreter, and the package, that run this."""
        path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
        environment = {**os.environ, "PATH": path, "PYTHONPATH": str(ROOT), "COLUMNS": "120", "MPLBACKEND": "Agg"}
        return subprocess.run(
            ["bash", "-c", self.variables + command],
            cwd=self.folder,
            env=environment,
            capture_output=True,
            text=True,
            timeout=600,
            check=False,
        )


def renew(page: str) -> None:
    """Put what its commands print now below them, and the pictures of a tutorial where the page has them."""
    text = (ROOT / page).read_text(encoding="utf-8")
    new = []
    with tempfile.TemporaryDirectory() as folder:
        reader = Reader(Path(folder))
        for block in blocks(page):
            ran = reader.run(block)
            if block.language == "console" and "run instead" not in block.said and ran:
                new.append((block.span, "".join(f"$ {command}\n{printed}" for command, _, printed in ran)))
        for name in re.findall(r"\]\((?:\.\./)?images/([\w.-]+\.png)\)", text):
            if (made := Path(folder) / name).is_file():
                (ROOT / "docs" / "images" / name).write_bytes(made.read_bytes())
    for (start, end), block_text in reversed(new):
        text = text[:start] + block_text.rstrip() + "\n" + text[end:]
    (ROOT / page).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("pages", nargs="+", metavar="PAGE", help="whose shown output is renewed, such as docs/arms.md")
    for name in parser.parse_args().pages:
        renew(name)
