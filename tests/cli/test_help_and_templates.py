"""Claims about what helps: examples in the help, templates to copy, and answers to what was nearly right."""

import errno
import json
import re
import shlex

import pytest
import typer
from short_experiment import SHORT

from asmc_pin import load_experiment
from asmc_pin.cli.dispatch import app
from asmc_pin.cli.entry import main
from asmc_pin.cli.examples import EXAMPLES
from asmc_pin.errors import ParameterError
from asmc_pin.experiment.finding import experiment_names
from asmc_pin.references import REFERENCES
from asmc_pin.words.mistyped import seconds

GROUP = typer.main.get_command(app)


def run(capsys, *words):
    """Exit status, standard output, standard error of a command."""
    with pytest.raises(SystemExit) as ended:
        main(words)
    out, err = capsys.readouterr()
    return ended.value.code, out, err


def test_every_command_has_examples_and_nothing_else_has():
    assert set(EXAMPLES) == set(GROUP.list_commands(None))


@pytest.mark.parametrize("line", [line for lines in EXAMPLES.values() for line in lines])
def test_every_example_is_a_line_that_its_command_takes(line):
    words = shlex.split(line)
    GROUP.get_command(None, words[0]).make_context(words[0], words[1:])


@pytest.mark.parametrize("command", sorted(EXAMPLES))
def test_help_shows_the_examples_whole(capsys, monkeypatch, command):
    monkeypatch.setenv("COLUMNS", "120")
    status, out, _ = run(capsys, command, "--help")
    assert status == 0
    for line in EXAMPLES[command]:
        assert f"asmc-pin {line}" in out


@pytest.mark.parametrize("name", experiment_names())
def test_a_copy_of_every_shipped_experiment_is_the_same_under_another_name(capsys, tmp_path, name):
    file = tmp_path / "mine.toml"
    status, out, _ = run(capsys, "new", str(file), "--from", name)
    assert status == 0
    assert shlex.split(out.splitlines()[-1].partition("asmc-pin ")[2]) == ["compare", str(file)]
    copy, original = load_experiment(file), load_experiment(name)
    assert copy.name == "mine"
    assert (copy.arm, copy.controllers, copy.duration) == (original.arm, original.controllers, original.duration)


def test_a_file_that_is_there_is_never_written_over(capsys, tmp_path):
    file = tmp_path / "mine.toml"
    file.write_text("mine")
    status, out, err = run(capsys, "new", str(file))
    assert (status, out) == (2, "")
    assert "is there already" in err
    assert file.read_text() == "mine"


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("mine.toml", "--from", "demmo"), "did you mean 'demo'"),
        (("mine.txt",), "ends in .toml"),
        (("../a b.toml",), "'../a b.toml' given"),
        (("nowhere/mine.toml",), "nowhere"),
    ],
)
def test_a_copy_that_cannot_be_made_says_why(capsys, tmp_path, monkeypatch, words, says):
    monkeypatch.chdir(tmp_path)
    status, out, err = run(capsys, "new", *words)
    assert (status, out) == (2, "")
    assert says in err
    assert not list(tmp_path.iterdir())


def test_the_list_of_experiments_names_each_and_says_what_it_is_about(capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "200")
    status, out, _ = run(capsys, "experiments")
    assert status == 0
    for name in experiment_names():
        assert re.search(rf"^{name} +\w+ +[\d.]+ +\w.+$", out, re.MULTILINE)


LOOP = ("stability", "two_link", "--mbar", "0.02", "--ks", "5")


@pytest.mark.parametrize(
    ("words", "given", "mends"),
    [
        ((*LOOP, "--beta", "1,2,3,4,5,6", "--period", "0.001"), "6 values", "--ks"),
        ((*LOOP, "--beta", "5", "--period", "1ms"), "'1ms'", "0.001 in s"),
        ((*LOOP, "--beta", "5", "--period", "1kHz"), "'1kHz'", "0.001 in s"),
        (("verify", "two_link", "--mbar", "0.1;0.2"), "'0.1;0.2'", "0.1,0.2"),
        (("verify", "two_link", "--mbar", "0.1", "--box", "joint_2=-90deg:90deg"), "'-90deg'", "-1.5708 in rad"),
        (("verify", "two_link", "--mbar", "0.1", "--certify", "--budget", "1y"), "'1y'", "2m"),
    ],
)
def test_what_is_nearly_a_number_is_answered_with_how_to_write_it(capsys, words, given, mends):
    status, out, err = run(capsys, *words)
    assert (status, out) == (2, "")
    assert given in err
    assert mends in err
    assert err.count("\n") == 1


GAINS = ("design", "two_link", "--gains", "--period")
SEARCH = ("verify", "two_link", "--mbar")


@pytest.mark.parametrize(
    ("words", "given", "mends"),
    [
        ((*SEARCH, "0.1", "--samples", "1e4"), "--samples", "'1e4' given, expected a valid integer"),
        ((*SEARCH, "0.1", "--samples", "9" * 20), f"--samples: {'9' * 20} given", "from 1 to 16777216"),
        ((*SEARCH, "1e300"), "--mbar: 1e+300", "between 1e-50 and 1e+50"),
        ((*SEARCH, "0.1", "--certify", "--budget", "-1m"), "'-1m' given", "90s, 2m, 1h"),
        ((*SEARCH, "0.1", "--certify", "--gap", "0"), "'--gap': 0 given", "between 0 and 1"),
        ((*SEARCH, "0.1", "--payload", "1@tipp"), "--payload: no link 'tipp'", "'tip'"),
        (("bounds", "two_link", "--scale", "0"), "--scale: [0.0, 0.0] given", "from 1e-6"),
        ((*LOOP, "--beta", "1e308", "--period", "0.001"), "--beta: got [1e+308", "between 1e-50 and 1e+50"),
        ((*LOOP, "--beta", "5", "--period", "1e-300"), "--period: 1e-300 s?", "at least 1e-09"),
        ((*LOOP, "--beta", "5", "--period", "1e9"), "--period: 1e+09 s?", "and below 1\n"),
        ((*LOOP, "--beta", "5", "--period", "0.001", "--law", "ppc", "--set", "gain=1"), "'gain'", "it has none"),
        ((*LOOP, "--beta", "5", "--period", "0.001", "--figures", "a_file"), "--figures: a_file", "a folder expected"),
        (("design", "two_link", "--bounds", "joint_1=-1:1"), "--bounds: -1:1", "leave the least out"),
        (("design", "two_link", "--bounds", "joint_1=0:1e20"), "--bounds: 0:1e+20", "leave the largest out"),
        (("design", "two_link", "--period", "0.001"), "--period", "add --gains"),
        ((*GAINS, "0.001", "--coulomb", "-1"), "--coulomb: got [-1.0, -1.0]", "0 or more"),
    ],
)
def test_what_no_computation_takes_is_one_message_with_the_option_as_it_was_typed(
    capsys, tmp_path, monkeypatch, words, given, mends
):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a_file").write_text("mine")
    status, out, err = run(capsys, *words)
    assert (status, out) == (2, "")
    (line,) = (line for line in err.splitlines(keepends=True) if "warning" not in line)
    assert given in line
    assert mends in line
    assert (tmp_path / "a_file").read_text() == "mine"


@pytest.mark.parametrize("key", ["mbar", "ks", "beta"])
def test_a_figure_of_an_experiment_whose_square_overflows_is_one_message_and_no_result(capsys, tmp_path, key):
    file = tmp_path / "short.toml"
    file.write_text(re.sub(rf"^{key} = .*$", f"{key} = 1e300", SHORT, count=1, flags=re.MULTILINE))
    status, out, err = run(capsys, "compare", str(file), "--out", str(tmp_path / "out"))
    assert (status, out) == (2, "")
    assert f"{key}: " in err
    assert "between 1e-50 and 1e+50" in err
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("words", [("0",), ("0.001", "--gain-margin", "0.5"), ("0.001", "--coulomb", "1,2,3")])
def test_gains_that_cannot_be_chosen_are_refused_before_an_mbar_is_designed_for_them(capsys, monkeypatch, words):
    def forbidden(*_args, **_options):
        raise AssertionError("an M̄ was designed")

    monkeypatch.setattr("asmc_pin.condition.design", forbidden)
    status, out, _ = run(capsys, *GAINS, *words)
    assert (status, out) == (2, "")


@pytest.mark.parametrize(
    ("text", "value"), [("60", 60.0), ("90s", 90.0), ("1m", 60.0), ("2 min", 120.0), ("1.5h", 5400.0)]
)
def test_a_time_may_have_its_unit(text, value):
    assert seconds(text) == value


def test_a_file_with_semicolons_is_answered_with_the_command_that_mends_it(tmp_path, monkeypatch):
    import subprocess

    monkeypatch.chdir(tmp_path)
    (tmp_path / "log.csv").write_text("t;q1;q2\n" + "".join(f"{i};0,{i};0,5\n" for i in range(6)))
    with pytest.raises(ParameterError, match="';' between its values") as raised:
        REFERENCES["csv"](path="log.csv")
    subprocess.run(str(raised.value).partition("that has: ")[2], shell=True, check=True)
    path = REFERENCES["csv"](path="comma.csv")
    assert path.points[3].tolist() == [0.3, 0.5]


def test_a_recording_with_semicolons_and_decimal_commas_is_read_as_one_with_commas(capsys, tmp_path):
    foreign, plain = tmp_path / "foreign.csv", tmp_path / "plain.csv"
    foreign.write_text("t;q1;q2\n0;0;0,5\n0,1;0;0,5\n")
    plain.write_text("t,q1,q2\n0,0,0.5\n0.1,0,0.5\n")
    command = ("verify", "two_link", "--mbar", "0.02", "--json", "--along")
    said = [json.loads(run(capsys, *command, str(log))[1]) for log in (foreign, plain)]
    assert said[0] | {"seconds": 0.0} == said[1] | {"seconds": 0.0}
    assert said[0]["worst_q"] == [0.0, 0.5]


@pytest.mark.parametrize("words", [("verify", "two_link", "--mbar", "0.01", "--samples", "64"), ("design", "two_link")])
def test_a_page_for_which_there_is_no_room_takes_nothing_of_the_verdict(capsys, monkeypatch, tmp_path, words):
    def full(path, *_args):
        raise OSError(errno.ENOSPC, "No space left on device", str(path))

    monkeypatch.setattr("asmc_pin.pages.condition_page.write_whole", full)
    status, out, err = run(capsys, *words, "--report", str(tmp_path / "page.html"))
    assert status == 2
    found, whole = (re.sub(r"[\d.]+ s\b", "", said) for said in (out, run(capsys, *words)[1]))
    assert found == whole
    assert "Lemma 1" in found
    assert "No space left on device" in err
    assert "Traceback" not in err
