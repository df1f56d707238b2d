"""The command line: statuses, messages, and where they go."""

import json
import re
from types import SimpleNamespace

import numpy as np
import pytest
from short_experiment import SHORT

from asmc_pin.cli import main
from asmc_pin.cli.commands.study_commands import print_comparison
from asmc_pin.pages.tables.text_table import Table

UR5 = (
    "0.14832641607830951,0.16745534835366926,0.15042781767398009,"
    "0.08106526290068174,0.09334419114818981,0.017136950741091284"
)


@pytest.fixture
def asmc_pin(capfd):
    """Run the command line in this process: status, standard output, standard error."""

    def run(*arguments):
        with pytest.raises(SystemExit) as end:
            main(list(arguments))
        out, err = capfd.readouterr()
        return end.value.code, out, err

    return run


@pytest.fixture
def experiment(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "short.toml"
    path.write_text(SHORT)
    return str(path)


def test_an_allowed_mbar_is_unrefuted_and_status_0(asmc_pin):
    status, out, _ = asmc_pin("verify", "ur5", "--mbar", UR5, "--samples", "4096")
    assert status == 0
    assert "unrefuted" in out
    assert "never prove" in out


def test_a_counter_example_is_status_1_and_can_be_checked_by_hand(asmc_pin):
    from asmc_pin import lemma1_norm, load_arm

    status, out, _ = asmc_pin("verify", "ur5", "--mbar", "1", "--samples", "1024", "--json")
    report = json.loads(out)
    assert status == 1
    assert report["verdict"] == "violated"
    assert report["kind"] == "sampled"
    assert report["upper"] is None
    hypotheses = "arm sha256 joints mbar armature payload locked box scope condition level"
    found = "verdict kind lower upper worst_q worst_payload worst_armature configurations seconds"
    assert set(report) == {*hypotheses.split(), *found.split()}
    mass = load_arm("ur5").mass_matrix(np.array(report["worst_q"]))
    assert lemma1_norm(mass, np.full(6, 1.0)) == pytest.approx(report["lower"], rel=1e-9)


def test_a_counter_example_in_a_range_says_which_end_it_belongs_to(asmc_pin):
    _, out, _ = asmc_pin("verify", "two_link", "--mbar", "0.01", "--payload", "0:2", "--samples", "256", "--json")
    assert "payload" in json.loads(out)["worst_case"]


def test_the_weighted_condition_is_never_called_lemma_1(asmc_pin):
    status, out, _ = asmc_pin("verify", "two_link", "--mbar", "0.01", "--condition", "weighted", "--samples", "256")
    assert status == 0
    assert "2M" in out
    assert "‖I − M⁻¹M̄‖₂" not in out
    assert "emma" not in out


def test_along_the_shipped_smooth_reference_the_norm_is_the_papers(asmc_pin):
    status, out, _ = asmc_pin("verify", "two_link", "--mbar", "0.01", "--along", "baek2016_simulation_smooth", "--json")
    assert status == 0
    assert json.loads(out)["lower"] == pytest.approx(0.9886, abs=5e-5)


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ([], "Missing command"),
        (["verify"], "ARM"),
        (["verify", "ur55", "--mbar", "1"], "did you mean 'ur5'"),
        (["verify", "ur5", "--mbar", "1,2"], "6"),
        (["verify", "ur5", "--mbar", "1,x"], "'x' is not a number"),
        (["verify", "ur5", "--mbar", "-1"], "positive"),
        (["verify", "ur5", "--mbar", "nan"], "finite"),
        (["verify", "ur5", "--mbar", "1", "--condition", "lemma2"], "lemma1"),
        (["verify", "ur5", "--mbar", "1", "--box", "elbow=0:1"], "elbow_joint"),
        (["verify", "ur5", "--mbar", "1", "--box", "elbow_joint=1:0"], "empty"),
        (["verify", "ur5", "--mbar", "1", "--box", "elbow_joint"], "JOINT=LO:HI"),
        (["verify", "ur5", "--mbar", "1", "--payload", "heavy"], "'heavy' is not a number"),
        (["verify", "ur5", "--mbar", "1", "--lock", "elbow_joint"], "JOINT=ANGLE"),
        (["verify", "ur5", "--mbar", "1", "--along", "nowhere"], "nowhere"),
        (["verify", "ur5", "--mbar", "1", "--frobnicate"], "--frobnicate"),
        (["compare", "nowhere"], "demo"),
        (["compare", "demo", "--out", "/proc/nowhere"], "/proc/nowhere cannot be written"),
        (["view", "nowhere"], "nowhere"),
        (["report", "nowhere"], "nowhere"),
        (["frobnicate"], "frobnicate"),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, list) else "",
)
def test_bad_input_is_one_message_and_status_2(asmc_pin, arguments, says, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    status, out, err = asmc_pin(*arguments)
    assert status == 2
    assert out == ""
    assert says in err
    assert "Traceback" not in err
    assert err.startswith("asmc-pin: ")


@pytest.mark.parametrize(
    ("raised", "status", "says"),
    [(KeyboardInterrupt(), 130, "interrupted"), (MemoryError("7 PiB"), 2, "out of memory: 7 PiB")],
)
def test_what_ends_a_run_from_outside_is_one_message_too(asmc_pin, monkeypatch, raised, status, says):
    def fail(*_args, **_kwargs):
        raise raised

    monkeypatch.setattr("asmc_pin.condition.verify", fail)
    given, out, err = asmc_pin("verify", "ur10", "--mbar", "0.1")  # an arm without doubts that would be told first
    assert (given, out) == (status, "")
    assert err.startswith(f"asmc-pin: {says}")
    assert err.count("\n") == 1


def test_no_equation_in_the_list_of_laws_is_cut(asmc_pin, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    status, out, err = asmc_pin("controllers")
    assert status == 0, err
    assert "…" not in out


@pytest.mark.parametrize("columns", [40, 80])
def test_no_controller_and_no_figure_of_seven_joints_is_cut(capsys, monkeypatch, columns):
    monkeypatch.setenv("COLUMNS", str(columns))
    header = ["controller", *(f"joint{i}" for i in range(1, 8)), "worst error [deg]", "chatter [N·m/s]"]
    rows = [[label, *["0.00123"] * 7, "0.0123", "123"] for label in ("Existing", "Proposed")]
    table = Table("RMS tracking error [deg]", header, rows)
    print_comparison(SimpleNamespace(overview=lambda: table, remarks=list))
    lines = capsys.readouterr().out.splitlines()
    for label in ("Existing", "Proposed"):
        (line,) = (line for line in lines if line.startswith(label))
        assert line.split() == [label, *["0.00123"] * 7, "0.0123", "123"]
        assert len(line) <= 80


def test_compare_says_who_diverged_and_still_ends_well(asmc_pin, experiment):
    status, out, err = asmc_pin("compare", experiment, "--json")
    assert status == 0, err
    result = json.loads(out)
    assert result["controllers"]["PPC"]["status"] == "ok"
    assert result["controllers"]["Wild"]["status"] == "diverged"
    assert result["controllers"]["Wild"]["rms_error"] == [None, None]
    assert result["error_units"] == ["deg", "deg"]


def test_an_existing_result_is_kept_unless_forced(asmc_pin, experiment, tmp_path):
    assert asmc_pin("compare", experiment)[0] == 0
    before = (tmp_path / "results" / "short" / "summary.md").read_bytes()
    status, out, err = asmc_pin("compare", experiment)
    assert status == 2
    assert "--force" in err
    assert out == ""
    assert (tmp_path / "results" / "short" / "summary.md").read_bytes() == before
    assert asmc_pin("compare", experiment, "--force")[0] == 0


def test_view_writes_a_page_that_needs_no_network(asmc_pin, experiment, tmp_path):
    assert asmc_pin("compare", experiment)[0] == 0
    status, out, _ = asmc_pin("view", "results/short", "--html", "page.html")
    assert status == 0
    assert "page.html" in out
    page = (tmp_path / "page.html").read_text(encoding="utf-8")
    assert not re.findall(r"<(?:script|link|img)[^>]+(?:src|href)=[\"']?https?:", page)


@pytest.mark.parametrize("command", ["arms", "controllers"])
def test_the_lists_are_json_too(asmc_pin, command):
    status, out, _ = asmc_pin(command, "--json")
    assert status == 0
    assert len(json.loads(out)[command]) >= 4


def test_the_version_is_the_packages(asmc_pin):
    from importlib.metadata import version

    status, out, _ = asmc_pin("--version")
    assert (status, out.strip()) == (0, f"asmc-pin {version('asmc-pin')}")
