"""Objects show themselves: as the lines that the command line prints, and as HTML in a notebook."""

from __future__ import annotations

import dataclasses
import re
from html import unescape

import numpy as np
import pytest
from short_experiment import SHORT

import asmc_pin
from asmc_pin.cli import main
from asmc_pin.words.shown import UNDEFINED, Shown, aligned, figure, sparkline

SMALL = [0.05, 0.01]


@pytest.fixture(scope="module")
def arm():
    return asmc_pin.load_arm("two_link", payload=0.5)


@pytest.fixture(scope="module")
def report(arm):
    return asmc_pin.verify(arm, SMALL, samples=256, starts=2)


@pytest.fixture(scope="module")
def compared(tmp_path_factory):
    folder = tmp_path_factory.mktemp("shown")
    (folder / "short.toml").write_text(SHORT.replace("[controllers.Wild]", '[controllers."<Wild>"]'), encoding="utf-8")
    return asmc_pin.compare(asmc_pin.load_experiment(folder / "short.toml"), folder / "out")


@pytest.fixture(scope="module")
def runs(compared):
    plant, laws = compared.experiment.build_plant(), compared.experiment.build_controllers()
    return [asmc_pin.rollout(plant, law, compared.experiment.build_reference(), 0.2, batch=2) for law in laws.values()]


@pytest.fixture(scope="module")
def things(arm, report, compared, runs):
    loop = asmc_pin.stability(arm, SMALL, 5.0, 5.0, 0.001, samples=64, limits=False)
    read = asmc_pin.load_result(compared.out)
    return [arm, report, loop, asmc_pin.design(arm, explain=False), compared, compared.experiment, read, *runs]


def text_of(html: str) -> str:
    return unescape(re.sub(r"<[^>]*>", " ", html))


def test_every_object_shows_itself_in_lines_and_in_the_same_words_as_html(things):
    for thing in things:
        assert isinstance(thing, Shown)
        said = text_of(thing._repr_html_())
        for line in (*thing.lines(), *thing.remarks()):
            assert line in str(thing)
            assert line in said
        header, rows = thing.table()
        assert {len(row) for row in rows} == {len(header)}
        for cell in (cell for row in (header, *rows) for cell in row):
            assert cell in said
        assert thing._repr_html_().count("<strong>") == 1


def test_repr_is_one_short_line(things):
    for thing in things:
        assert "\n" not in repr(thing)
        assert len(repr(thing)) < 250, repr(thing)
        assert type(thing).__name__ in repr(thing)


def test_the_command_line_prints_what_the_report_says(arm, report, capsys):
    with pytest.raises(SystemExit):
        main(["verify", "two_link", "--payload", "0.5", "--mbar", "0.05,0.01"])
    printed = capsys.readouterr().out
    for line in report.hypotheses.lines():
        assert line in printed
    header = next(line for line in printed.splitlines() if line.startswith("joint "))
    assert header.split() == " ".join(report.table()[0]).split()


def test_the_figures_of_a_verdict_are_those_of_the_report(report, arm):
    assert f"{report.lower:.6g}" in str(report)
    _, rows = report.table()
    assert [row[0] for row in rows] == list(arm.joint_names)
    assert [float(row[3]) for row in rows] == pytest.approx(report.worst_q, abs=1e-6)
    assert [float(row[4]) for row in rows] == pytest.approx(np.degrees(report.worst_q), abs=1e-2)


def test_an_arm_says_what_it_carries_and_what_its_urdf_leaves_out(arm):
    assert "payload: 0.5 kg" in str(arm)
    assert "not declared" in str(arm)
    assert not np.isfinite(arm.effort_limit).any()
    assert "payload" not in str(asmc_pin.load_arm("two_link"))


def test_a_rollout_shows_its_largest_errors(runs):
    good = runs[0]
    _, rows = good.table()
    largest = np.abs(good.q_ref - good.q).max(axis=(0, 1))
    assert [row[1] for row in rows] == [f"{value:.4g}" for value in largest]
    assert "diverged" not in str(good)
    assert good._repr_html_().count("<svg") == len(good.joint_names)


def test_what_a_run_that_diverged_does_not_have_is_a_dash(runs):
    wild = runs[1]
    assert set(wild.status) == {"diverged"}
    assert f"2 diverged, first at t = {wild.end_time.min():.4g} s" in str(wild)
    assert all(row[1:] == [UNDEFINED, UNDEFINED] for row in wild.table()[1])
    assert "nan" not in str(wild) + wild._repr_html_()


def test_one_trial_that_diverged_does_not_hide_the_others(runs):
    good, wild = runs
    mixed = dataclasses.replace(
        good,
        q=np.stack([good.q[0], wild.q[0]]),
        torque=np.stack([good.torque[0], wild.torque[0]]),
        status=("ok", "diverged"),
        end_time=np.array([good.end_time[0], wild.end_time[0]]),
    )
    assert mixed.table() == good.table()
    assert "1 diverged" in str(mixed)


def test_every_table_of_an_object_is_one_in_a_notebook_too():
    seen = asmc_pin.inspect("two_link")
    assert len(seen.tables()) == 2
    assert seen._repr_html_().count("<table>") == 2
    header = aligned(seen.bodies())[0]
    assert header in str(seen)
    assert header not in text_of(seen._repr_html_())


def test_an_experiment_says_in_words_what_its_arm_carries(compared):
    laden = compared.experiment.replace(
        arm={"source": "two_link", "payload": {"mass": 2.0, "com": [0.0, 0.0, 0.1], "link": "tip"}, "repair": True}
    )
    said = laden.lines()[0]
    assert said.endswith("on two_link, payload 2 kg at (0, 0, 0.1) m on tip, repair")


def test_a_design_that_does_not_exist_has_dashes(arm):
    hopeless = asmc_pin.design(arm, bounds={name: (100.0, 200.0) for name in arm.joint_names}, explain=False)
    assert hopeless.mbar is None
    assert all(row[1] == row[-1] == UNDEFINED for row in hopeless.table()[1])
    assert hopeless.headline() in text_of(hopeless._repr_html_())


def test_names_are_escaped_and_steer_no_terminal(compared):
    html = compared._repr_html_()
    assert "&lt;Wild&gt;" in html
    assert "<Wild>" not in html

    class Rude(Shown):
        def lines(self):
            return ["<b>\x1b[31mred\n"]

        def table(self):
            return ["<i>"], [["a\nb"]]

    shown = Rude()
    assert "\x1b" not in str(shown) + shown._repr_html_() + repr(shown)
    assert str(shown).count("\n") == 2
    assert "<b>" not in shown._repr_html_()
    assert "<i>" not in shown._repr_html_()


def test_a_table_is_aligned_by_what_a_terminal_shows():
    lines = aligned((["joint", "m̄", "手"], [["a", "1", "2"], ["long name", "10", "–"]]))
    assert lines == ["joint       m̄  手", "a           1   2", "long name  10   –"]
    assert figure(float("nan")) == UNDEFINED
    assert figure(0.25) == "0.25"


def test_a_curve_breaks_where_a_value_is_not_defined_and_stays_within_its_frame():
    path = re.search(r' d="([^"]*)"', sparkline([0.0, 1.0, float("nan"), 3.0, 2.0], "<e>"))[1]
    assert path.count("M") == 2
    assert path.count("L") == 2
    numbers = [float(x) for x in re.findall(r"[\d.]+", path)]
    assert min(numbers) >= 0.0
    assert "&lt;e&gt;" in sparkline([float("nan")] * 3, "<e>")
    assert "nan" not in sparkline([float("nan")] * 3, "e")
    long = re.search(r' d="([^"]*)"', sparkline([float(i) for i in range(10_000)], "e"))[1]
    assert long.count("L") <= 200


def test_a_check_shows_itself_by_its_own_means():
    result = asmc_pin.CheckResult("forged\x1b.cert", False, ("it is <forged>",), None, None, (), 0.5)
    assert str(result).splitlines()[1] == "problem: it is <forged>"
    assert "NOT VALID" in repr(result)
    assert "\x1b" not in str(result) + repr(result)
