"""Tables and figures: figures as a person reads them, LaTeX that compiles, curves that keep their chatter."""

import re
import subprocess

import needs
import numpy as np
import pandas as pd
import pytest
import xarray as xr
from PIL import Image

from asmc_pin.metrics import METRICS
from asmc_pin.monitors import CAUSES, STATEMENTS
from asmc_pin.pages.comparison_figures import FIGURES, draw_figures
from asmc_pin.pages.curves import envelope, running_max, spread, thinned
from asmc_pin.pages.figure_style import line_look
from asmc_pin.pages.html_fragments import table_html
from asmc_pin.pages.latex_table import latex_table
from asmc_pin.pages.summary_tables import metric_table, metric_tables_markdown, overview, per_joint, short_names
from asmc_pin.pages.tables.pair_tables import pair_table
from asmc_pin.pages.tables.text_table import Table, markdown_table, number
from asmc_pin.pages.theorem_tables import theorems_latex
from asmc_pin.words.media import for_latex


def summary(joints=("arm_shoulder_joint", "arm_elbow_joint"), kinds=("revolute", "revolute"), **columns):
    rows = [
        {
            "experiment": "a_b",
            "arm": "arm",
            "controller": label,
            "law": "ppc",
            "trial": 0,
            "joint": joint,
            "joint_kind": kind,
            "status": "ok",
            "end_time": 1.0,
            **dict.fromkeys(METRICS, 1.0),
            "trip_time": np.nan,  # no robot is named
        }
        for label in ("PPC", "50% | {x}_1")
        for joint, kind in zip(joints, kinds, strict=True)
    ]
    frame = pd.DataFrame(rows)
    for name, values in columns.items():
        frame[name] = values
    return frame


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.0, "0"),
        (1.0, "1.00"),
        (0.0123456, "0.0123"),
        (9.996, "10.0"),
        (99.96, "100"),
        (1234.5, "1234"),
        (-0.00012345, "-0.000123"),
        (1.5e-7, "1.50e-07"),
        (2.5e7, "2.50e+07"),
        (float("nan"), "–"),
        (float("inf"), "∞"),
    ],
)
def test_figures_have_three_digits_and_no_needless_exponent(value, text):
    assert number(value) == text


def test_joint_names_lose_what_all_of_them_share_and_stay_apart():
    assert short_names(["panda_joint1", "panda_joint2"]) == ["joint1", "joint2"]
    assert short_names(["shoulder_pan_joint", "elbow_joint"]) == ["shoulder_pan", "elbow"]
    assert short_names(["joint_1", "joint_2"]) == ["joint_1", "joint_2"]
    assert short_names(["hinge"]) == ["hinge"]
    assert short_names(["a", "b"]) == ["a", "b"]


def test_a_table_is_controllers_by_joints_in_degrees():
    table = metric_table(summary(rms_error=np.radians([1.0, 2.0, 3.0, 4.0])), "rms_error")
    assert table.title == "RMS tracking error [deg]"
    assert table.header == ["controller", "shoulder", "elbow"]
    assert table.rows == [["PPC", "1.00", "2.00"], ["50% | {x}_1", "3.00", "4.00"]]


def test_a_sliding_joint_is_shown_in_mm_beside_a_turning_one_in_degrees():
    table = metric_table(summary(kinds=("prismatic", "revolute"), rms_error=[0.001, np.pi, 0.002, np.pi]), "rms_error")
    assert table.header == ["controller", "shoulder [mm]", "elbow [deg]"]
    assert table.rows[0] == ["PPC", "1.00", "180"]
    assert metric_table(summary(kinds=("prismatic", "revolute")), "torque_rms").header[1] == "shoulder [N]"


def test_the_overview_has_the_worst_error_and_the_whole_chatter_and_the_status_only_if_one_failed():
    table = overview(summary(max_error=np.radians([1.0, 3.0, 2.0, 1.0]), torque_variation=[10.0, 20.0, 1.0, 2.0]))
    assert table.header[-2:] == ["worst error [deg]", "chatter [N·m/s]"]
    assert [row[-2:] for row in table.rows] == [["3.00", "30.0"], ["2.00", "3.00"]]
    failed = summary(status=["diverged", "diverged", "ok", "ok"], end_time=[0.25, 0.25, 1.0, 1.0])
    assert [row[-1] for row in overview(failed).rows] == ["diverged at 0.25 s", "ok"]


def test_markdown_marks_the_smallest_figure_and_keeps_its_columns():
    frame = summary(rms_error=np.radians([1.0, np.nan, 0.5, np.nan]))
    text = markdown_table(metric_table(frame, "rms_error"))
    lines = text.splitlines()
    assert lines[2] == "| PPC | 1.00 | – |"
    assert lines[3] == r"| 50% \| {x}_1 | **0.500** | – |"
    assert {len(re.findall(r"(?<!\\)\|", line)) for line in lines} == {4}


def marked_by(text, opening, closing):
    return re.findall(f"{re.escape(opening)}([^*}}<]*){re.escape(closing)}", text)


@pytest.mark.parametrize("name", METRICS)
def test_every_kind_of_table_marks_the_same_best_figure_as_the_metric_says(name):
    frame = summary(**{name: np.array([1.0, 4.0, 2.0, 3.0])})
    _, _, values = per_joint(frame, name)
    pick = {"smallest": np.min, "largest": np.max, None: None}[METRICS[name].best]
    shown = "{:.0f}".format if METRICS[name].quantity == "count" else number  # of ticks there are no parts
    expected = [] if pick is None else sorted(shown(pick(column)) for column in values[:, 0].T)
    table = metric_table(frame, name)
    assert sorted(marked_by(markdown_table(table), "**", "**")) == expected
    assert sorted(marked_by(table_html(table, {}), '<td class="best">', "</td>")) == expected
    assert sorted(marked_by(latex_table(frame, [name]), r"\textbf{", "}")) == expected


def test_a_metric_of_which_more_is_better_has_its_largest_figure_marked():
    table = Table(
        "", ["controller", "a", "b"], [["one", "1.0", "–"], ["two", "3.0", "2"]], [None, "largest", "largest"]
    )
    assert table.marked() == {(1, 1), (1, 2)}


def test_the_overview_marks_what_the_metrics_in_it_mark():
    table = overview(summary(max_error=np.radians([1.0, 3.0, 2.0, 1.0]), torque_variation=[10.0, 20.0, 1.0, 2.0]))
    assert {table.header[column] for _, column in table.marked()} == {"worst error [deg]", "chatter [N·m/s]"}
    assert markdown_table(table).count("**") == 4


def test_equal_figures_have_no_winner_and_metrics_without_any_figure_no_table():
    frame = summary(peak_gain=np.nan)
    text = metric_tables_markdown(frame)
    assert "**" not in text
    assert METRICS["peak_gain"].title not in text
    assert f"`{METRICS['final_gain'].formula}`" in text


def test_a_figure_that_half_the_step_moves_says_so_where_it_stands_and_is_not_called_the_best():
    frame = summary(
        rms_error=np.radians([1.0, 2.0, 3.0, 4.0]),
        moved_rms_error=[0.014, -0.11, 0.17, np.nan],
        max_error=np.radians([1.0, 2.0, 3.0, 4.0]),
        moved_max_error=[0.0, 0.2, 0.0, 0.01],
        torque_variation=[10.0, 20.0, 1.0, 2.0],
        moved_torque_variation=[0.5, 0.0, 0.0, 0.0],
    )
    table = overview(frame)
    # Finer, the worst error of the first is 2.5, and its chatter 20 + 20.
    assert table.rows[0][1:] == ["1.00", "2.00 (±11 %)", "2.00 (±20 %)", "30.0 (±25 %)"]
    assert table.rows[1][1:] == ["3.00 (±17 %)", "4.00", "4.00", "3.00"]
    assert table.marked() == {(0, 1), (1, 4)}
    assert r"\textbf{1.00} & 2.00 ($\pm$11 \%)" in latex_table(frame, ["rms_error"])
    assert "(±17 %)" in table_html(metric_table(frame, "rms_error"), {})
    assert "±" not in str(overview(summary()))


def ensemble(first, second, failed=0, **columns):
    """A summary of two controllers on one joint, from their figures of each trial; the first fails in its last ones."""
    one = summary(joints=("j",), kinds=("revolute",))
    parts = []
    for k, figures in enumerate((first, second)):
        for trial, figure in enumerate(figures):
            gone = k == 0 and trial >= len(figures) - failed
            row = one.iloc[[k]].assign(trial=trial, rms_error=np.nan if gone else np.radians(figure))
            parts.append(row.assign(status="diverged", end_time=0.25 + 0.01 * trial) if gone else row)
    return pd.concat(parts, ignore_index=True).assign(**columns)


DRAW = np.linspace(0.9, 1.1, 16)


def test_several_trials_are_one_row_with_the_median_and_its_range_in_every_kind_of_table():
    frame = ensemble(DRAW, 3.0 + 0.0 * DRAW)
    table = metric_table(frame, "rms_error")
    assert table.rows == [["PPC", "1.00"], ["50% | {x}_1", "3.00"]]
    assert table.ranges == {(0, 1): ("0.910", "1.09")}  # where all trials are printed alike there is no range
    assert "| PPC | **1.00** [0.910 … 1.09] |" in markdown_table(table)
    assert '<td class="best">1.00<small>0.910 … 1.09</small></td>' in table_html(table, {})
    assert r"PPC & \textbf{1.00} $_{0.910}^{1.09}$ \\" in latex_table(frame, ["rms_error"])
    assert table.texts()[0] == ["PPC", "1.00 [0.910 … 1.09]"]


def test_over_several_trials_the_best_is_marked_only_where_the_paired_ratio_excludes_one():
    near = DRAW[::-1] * 1.01
    assert metric_table(ensemble(DRAW, near), "rms_error").marked() == set()
    # Smaller by as little, but in each and every trial.
    assert metric_table(ensemble(DRAW, 1.01 * DRAW), "rms_error").marked() == {(0, 1)}
    assert metric_table(ensemble(DRAW[:3], 1.01 * DRAW[:3]), "rms_error").marked() == set()  # too few to tell
    for text in (markdown_table(metric_table(ensemble(DRAW, near), "rms_error")), latex_table(ensemble(DRAW, near))):
        assert "**" not in text
        assert "textbf" not in text


def test_failures_open_the_range_and_are_counted_and_most_failing_leaves_no_figure():
    table = overview(ensemble(DRAW[::-1], 3.0 + 0.0 * DRAW, failed=3))  # the three smallest of it
    assert table.rows[0][1] == "1.04"
    assert table.ranges[0, 1] == ("0.950", "∞")
    assert [row[-1] for row in table.rows] == ["3 of 16 diverged, the first at 0.38 s", "ok"]
    assert (0, 1) in table.marked()  # 13 of 16 trials are better
    assert overview(ensemble(DRAW, 3.0 + 0.0 * DRAW, failed=9)).rows[0][1] == "–"
    assert (0, 1) not in overview(ensemble(DRAW, 3.0 + 0.0 * DRAW, failed=7)).marked()
    assert r"$_{0.910}^{\infty}$" in latex_table(ensemble(DRAW, DRAW, failed=3), ["rms_error"])


def test_every_pair_is_told_with_its_interval_and_whether_its_order_is_certain():
    table = pair_table(ensemble(DRAW, 2.0 * DRAW))
    row = table.rows[0]
    assert row[0].endswith(": PPC < 50% | {x}_1")
    assert row[1:] == ["0.500", *row[2:4], "certain"]
    assert float(row[2]) < 0.01
    alike = pair_table(ensemble(DRAW, DRAW))
    assert {row[-1] for row in alike.rows} == {"not certain"}
    assert pair_table(ensemble(DRAW[:1], DRAW[:1])) is None


def test_latex_escapes_what_has_a_meaning_in_latex():
    assert for_latex(r"50% | {x}_1 & $\alpha$ #~^") == (
        r"50\% \textbar{} \{x\}\_1 \& \$\textbackslash{}alpha\$ \#\textasciitilde{}\textasciicircum{}"
    )
    assert for_latex("s [N·m/s], rad/s²: –") == r"s [N\,m/s], rad/s$^2$: --"


def test_a_latex_table_has_as_many_cells_in_each_row_as_columns():
    text = latex_table(summary())
    assert r"\begin{tabular}{lrr}" in text
    body = re.search(r"\\toprule(.*)\\bottomrule", text, re.DOTALL)[1]
    for line in body.splitlines():
        cells = line.removesuffix(r" \\")
        spans = sum(int(n) - 1 for n in re.findall(r"\\multicolumn\{(\d+)\}", cells))
        if line.endswith(r"\\"):
            assert len(re.findall(r"(?<!\\)&", cells)) + 1 + spans == 3, line
    assert text.count("{") - text.count(r"\{") == text.count("}") - text.count(r"\}")
    assert all(f"[{unit}]" in text for unit in ("deg", r"N\,m", r"N\,m/s"))


@pytest.mark.parametrize("joints", [2, 7])
def test_the_latex_table_compiles_with_booktabs_alone(tmp_path, joints):
    names = tuple(f"joint_{i}" for i in range(joints))
    frame = summary(joints=names, kinds=("revolute",) * joints, peak_gain=np.nan)
    frame["rms_error"] = np.linspace(0.0, 1.0, len(frame))
    (tmp_path / "summary.tex").write_text(latex_table(frame, list(METRICS)), encoding="utf-8")
    (tmp_path / "page.tex").write_text(
        r"\documentclass{article}\usepackage{booktabs}\begin{document}\input{summary.tex}\end{document}"
    )
    command = [needs.program("latex"), "-interaction=nonstopmode", "-halt-on-error", "page.tex"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout[-2000:]


def test_thinning_keeps_the_envelope_of_chatter_and_the_order_of_time():
    time = np.arange(20_000) * 1e-3
    values = np.sin(time) + 0.3 * np.where(np.arange(time.size) % 2, 1.0, -1.0)
    values[7_777] = 5.0
    thin_time, thin = thinned(time, values, points=500)
    assert thin.size <= 1_000
    assert np.all(np.diff(thin_time) >= 0.0)
    assert (thin.min(), thin.max()) == (values.min(), 5.0)
    for start in range(0, 20, 5):
        window = (time >= start) & (time < start + 5)
        shown = (thin_time >= start) & (thin_time < start + 5)
        assert thin[shown].max() == pytest.approx(values[window].max(), abs=1e-3)
        assert thin[shown].min() == pytest.approx(values[window].min(), abs=1e-3)


def test_thinning_leaves_short_curves_alone_and_gaps_open():
    time = np.arange(5_000.0)
    same = thinned(time[:100], time[:100])
    assert np.array_equal(same[1], time[:100])
    values = np.where(time < 2_500, time, np.nan)
    thin_time, thin = thinned(time, values, points=100)
    assert np.nanmax(thin) == 2_499
    assert np.isnan(thin[thin_time > 2_600]).all()


def test_the_envelope_of_a_band_contains_it_and_keeps_its_gaps():
    time = np.arange(5_000) * 0.01
    low, high = np.sin(time) - 0.1, np.sin(time) + 0.1
    low[4_000:] = high[4_000:] = np.nan
    middle, below, above = envelope(time, low, high, windows=100)
    assert middle.size == 100
    assert (below[:80] <= np.interp(middle[:80], time, low) + 1e-12).all()
    assert (above[:80] >= np.interp(middle[:80], time, high) - 1e-12).all()
    assert np.isnan(below[80:]).all()
    assert envelope(time[:10], low[:10], high[:10])[0] is not None


def test_a_running_maximum_never_understates():
    time = np.arange(1_000) * 0.01
    middle, largest = running_max(time, np.abs(np.sin(5 * time)), windows=20)
    assert middle.size == 20
    assert largest.min() > 0.9
    assert np.isnan(running_max(time, np.full(1_000, np.nan))[1]).all()


def test_the_spread_compares_laws_that_ran_to_the_end():
    error = np.ones((3, 10, 2))
    error[1] *= 4.0
    error[2, 5:] = np.nan
    assert spread(error) == pytest.approx(4.0)
    assert spread(error[:1]) == 1.0


@pytest.mark.parametrize("scale", [1.0, 1e3])
def test_every_figure_is_drawn_for_any_number_of_joints_also_when_laws_diverge_or_differ_widely(tmp_path, scale):
    time = np.arange(50) * 0.01
    labels, joints = ["PPC", "Wild", r"$\wrong$ & 50%"], [f"j_{i}" for i in range(4)]
    wave = np.sin(time)[None, :, None] * np.array([1.0, 1.0, scale])[:, None, None] * np.ones(4)
    wave[1, 10:] = np.nan
    dims = ("controller", "trial", "time", "joint")
    dataset = xr.Dataset(
        {name: (dims, wave[:, None]) for name in ("q", "v", "torque", "s", "gain")}
        | {"q_ref": (("time", "joint"), np.zeros((50, 4)))},
        coords={
            "controller": labels,
            "time": time,
            "joint": joints,
            "joint_kind": ("joint", ["prismatic"] + ["revolute"] * 3),
        },
    )
    paths = draw_figures(dataset, tmp_path / "figures", np.array([1.0, np.inf, 2.0, 3.0]))
    assert [path.stem for path in paths] == list(FIGURES)
    for path in paths:
        assert path.read_bytes().startswith(b"\x89PNG")
        assert path.with_suffix(".pdf").read_bytes().startswith(b"%PDF")


TWO_COLUMNS = r"""\documentclass[twocolumn]{article}
\usepackage{booktabs,graphicx}
\setlength{\textwidth}{516pt}\setlength{\columnsep}{12pt}\setlength{\oddsidemargin}{-24pt}
\setlength{\textheight}{690pt}\setlength{\topmargin}{-50pt}
\begin{document}
%s
\end{document}
"""
"""The measures of a two-column journal (IEEE): columns of 252 pt."""


def wide_run(joints: int, controllers: list[str]) -> xr.Dataset:
    """Smooth curves of every signal, with long names."""
    rng, time = np.random.default_rng(1), np.linspace(0.0, 4.0, 801)
    shape = (len(controllers), 1, len(time), joints)
    axes = ("controller", "trial", "time", "joint")
    signals = {name: (axes, rng.normal(size=shape).cumsum(axis=2)) for name in ("q", "v", "torque", "s", "gain")}
    signals["gain"] = (axes, np.abs(signals["gain"][1]))
    names = [f"a_rather_long_name_{i}_joint" for i in range(joints)]
    return xr.Dataset(
        signals | {"q_ref": (("time", "joint"), rng.normal(size=(len(time), joints)).cumsum(axis=0))},
        {
            "controller": controllers,
            "trial": [0],
            "time": time,
            "joint": names,
            "joint_kind": ("joint", ["revolute"] * joints),
        },
    )


@pytest.mark.parametrize(("joints", "trials"), [(2, 1), (3, 16), (7, 16)])
def test_a_two_column_paper_takes_every_figure_and_table_without_an_overfull_box(tmp_path, joints, trials):
    labels = ["PPC", "Existing law", "A label of some length", "Proposed", "Boundary layer"]
    names = [f"arm_{i}_joint" for i in range(joints)]
    rows = pd.concat([summary(names, ["revolute"] * joints) for _ in range(3)], ignore_index=True)
    rows = rows.iloc[: len(labels) * joints]
    rows["controller"] = np.repeat(labels, joints)
    rows = pd.concat([rows.assign(trial=trial) for trial in range(trials)]).sort_values(["controller", "trial"])
    rng = np.random.default_rng(0)
    for metric in METRICS:
        rows[metric] = np.exp(rng.normal(-4.0, 1.0, len(rows)))
    draw_figures(wide_run(joints, labels), tmp_path)
    (tmp_path / "summary.tex").write_text(latex_table(rows), encoding="utf-8")
    (tmp_path / "theorems.tex").write_text(theorems_latex(claims_of(labels), "an arm with a load"), encoding="utf-8")
    body = [r"\input{summary.tex}", r"\input{theorems.tex}"]
    for name in FIGURES:
        image = Image.open(tmp_path / f"{name}.png")
        width = image.width / image.info["dpi"][0]
        star = "*" if width > 4.0 else ""
        body.append(rf"\begin{{figure{star}}}\centering\includegraphics{{{name}.pdf}}\end{{figure{star}}}")
    (tmp_path / "paper.tex").write_text(TWO_COLUMNS % "\n".join(["Text.", *body]), encoding="utf-8")
    command = [needs.program("latex"), "-interaction=nonstopmode", "-halt-on-error", "paper.tex"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout[-2000:]
    assert "Overfull" not in done.stdout, re.findall(r"Overfull.*\n.*", done.stdout)
    assert "too large for page" not in done.stdout


def claims_of(labels):
    """The longest cell that a claim can have, for every claim."""
    causes = dict.fromkeys(CAUSES, 0) | {"sampling": 40, "saturation": 60}
    row = {"trial": 0, "status": "broken", "checked": 200, "broken": 100, "until": np.nan, **causes}
    return pd.DataFrame([{"controller": label, "claim": key, **row} for label in labels for key in STATEMENTS])


def test_the_lines_of_eight_controllers_are_told_apart_without_their_colours():
    looks = [line_look(k, "black", 100) for k in range(8)]
    assert len({(str(look["linestyle"]), look["marker"]) for look in looks}) == 8
    assert all(len({looks[k]["linestyle"] for k in (j, j + 1)}) == 2 for j in range(7)), "neighbours differ in dashes"
