"""The documentation says what the code does: what is derived is fresh, examples run, names and links are right."""

import re
import tomllib

import generate
import pytest
from derived_parts import PARTS
from paths import REPOSITORY

from asmc_pin.experiment import experiment_names

ROOT = REPOSITORY
PAGES = sorted([*generate.pages(), ROOT / "benchmarks" / "README.md"])


def test_everything_that_is_derived_is_fresh():
    assert not generate.stale(), "run make docs"


@pytest.mark.parametrize("path", [path for path in generate.pages() if generate.parts_of(path.read_text("utf-8"))])
def test_a_stale_part_is_noticed(path):
    text = path.read_text(encoding="utf-8")
    for name in generate.parts_of(text):
        stale = re.sub(rf"(<!-- begin {name} -->\n.*?)\w", r"\1#", text, count=1, flags=re.DOTALL)
        assert stale != text
        assert generate.rendered(stale) == text


def test_every_part_stands_somewhere():
    shown = [name for path in generate.pages() for name in generate.parts_of(path.read_text(encoding="utf-8"))]
    assert sorted(set(shown)) == sorted(PARTS)


@pytest.mark.parametrize(
    "text", ["<!-- begin arms -->\n", "<!-- end arms -->", "<!-- begin arms -->\n<!-- end metrics -->"]
)
def test_a_part_that_does_not_end_is_an_error(text):
    with pytest.raises(SystemExit, match="alone"):
        generate.rendered(text)


def test_a_part_that_nobody_makes_is_an_error():
    with pytest.raises(SystemExit, match="there is no part 'amrs'"):
        generate.rendered("<!-- begin amrs -->\n<!-- end amrs -->")


def test_the_readme_has_one_picture_two_commands_and_three_questions_with_links_on_the_screen_before_its_tables():
    screen = (ROOT / "README.md").read_text(encoding="utf-8").partition("\n|")[0]
    assert screen.count("<img ") + screen.count("![") == 1
    commands = [line for block in re.findall(r"```sh\n(.*?)```", screen, re.DOTALL) for line in block.splitlines()]
    assert [line.split("#")[0].strip() for line in commands] == ["make demo", "make test"]
    questions = re.findall(r"^\*\*[^*]+\?\*\*.*?(?=^$)", screen, re.DOTALL | re.MULTILINE)
    assert len(questions) == 3
    assert all("](docs/" in question for question in questions)
    assert len(screen.splitlines()) <= 45


def test_every_shipped_experiment_is_explained():
    text = (ROOT / "docs" / "experiments.md").read_text(encoding="utf-8")
    for name in experiment_names():
        assert f"`{name}`" in text or (name.endswith("_reconciled") and "`baek2016_…_reconciled`" in text), name


@pytest.mark.parametrize("path", PAGES, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_links_lead_to_files_of_the_repository(path):
    prose = re.sub(r"<!--.*?-->|```.*?```|`[^`\n]*`", "", path.read_text(encoding="utf-8"), flags=re.DOTALL)
    for target in re.findall(r"\]\((?!https?:|#)([^)#\s]+)", prose):
        assert (path.parent / target).exists(), f"{path.name} links to {target}"


def prose_lines(text):
    """The lines of a page that are prose: no table, code, derived or generated part, and no image alone on its line."""
    text = re.sub(r"^<!-- (begin|from here: ).*?^<!-- (end|to here: )", "", text, flags=re.MULTILINE | re.DOTALL)
    text = re.sub(r"<!--.*?-->", "", text, flags=re.DOTALL)
    text = re.sub(r"^```.*?^```", "", text, flags=re.MULTILINE | re.DOTALL)
    for line in text.splitlines():
        if not line.startswith(("|", "    ")) and not re.fullmatch(r"!?\[[^\]]*\]\([^)]*\)", line.strip()):
            yield line


@pytest.mark.parametrize(
    "text", ["word " * 24 + "\n", "- " + "item " * 24, "<!-- begin x -->\n<!-- end x -->\n" + "a" * 120]
)
def test_a_long_line_of_prose_is_seen(text):
    assert max(map(len, prose_lines(text))) >= 120


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_prose_has_lines_under_120_characters(page):
    long = [line for line in prose_lines(page.read_text(encoding="utf-8")) if len(line) >= 120]
    assert not long


@pytest.mark.long
def test_the_python_example_runs(tmp_path, monkeypatch):
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    (example,) = re.findall(r"## In Python\n\n```python\n(.*?)```", text, re.DOTALL)
    assert len([line for line in example.splitlines() if line.strip()]) <= 12
    monkeypatch.chdir(tmp_path)
    namespace: dict[str, object] = {}
    exec(example, namespace)
    assert namespace["report"].verdict == "unrefuted"
    assert set(namespace["comparison"].rows["controller"]) == {"PPC", "BSMC", "Existing", "Proposed"}


def test_every_dependency_says_what_it_is_for():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    wanted = [
        *project["dependencies"],
        *(item for extra in project["optional-dependencies"].values() for item in extra),
    ]
    names = {re.match(r"[\w-]+", item)[0] for item in wanted}
    rows = re.findall(r"^\| (.*?) \|", (ROOT / "docs" / "dependencies.md").read_text(encoding="utf-8"), re.MULTILINE)
    assert names <= {word for row in rows for word in re.findall(r"[\w-]+", row)}


def test_the_version_is_one_and_has_its_section_in_the_changelog():
    version = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["version"]
    assert f"\nversion: {version}\n" in (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    sections = re.findall(r"^## (\S+)", (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"), re.MULTILINE)
    assert sections[0] == version
    assert sections == sorted(set(sections), key=lambda x: [int(n) for n in x.split(".")], reverse=True)


def test_contributing_names_commands_that_make_has():
    targets = set(re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE))
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    lines = re.findall(r"^make (.*?)(?: +#.*)?$", text, re.MULTILINE) + re.findall(r"`make ([^`]*)`", text)
    named = {word for line in lines for word in line.split() if "=" not in word}
    assert named >= {"demo", "test", "lint", "typecheck", "test-all", "fuzz", "docs"}
    assert named <= targets


def test_files_that_contributing_and_the_hooks_name_exist():
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    for name in re.findall(r"`((?:asmc_pin|tests|urdf|\.ci)/[\w./]*)`", text):
        assert (ROOT / name).exists(), name
    hooks = (ROOT / ".pre-commit-config.yaml").read_text(encoding="utf-8")
    assert set(re.findall(r"repo: (.*)", hooks)) == {"local"}
    assert "run: .ci/run" in (ROOT / ".github" / "workflows" / "ci.yml").read_text(encoding="utf-8")
    assert (ROOT / ".ci" / "run").exists()
