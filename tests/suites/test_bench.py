"""A benchmark gives every law the same conditions, drops no failure, and ends the same however often it was cut."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from scipy import stats

import asmc_pin
from asmc_pin.controllers import CONTROLLERS
from asmc_pin.errors import ExperimentError, ParameterError, ResultError
from asmc_pin.pages.benches.bench_tables import bench_lines, mean_table, pair_table_of, problem_table
from asmc_pin.suites.bench_result import bench_json
from asmc_pin.suites.bench_verb import findings_of
from asmc_pin.suites.cell_experiment import cell_experiment
from asmc_pin.suites.cell_runs import CellResult, from_json
from asmc_pin.suites.suite_reading import DEFAULT, load_suite
from asmc_pin.tuning.candidate_runs import draws_of

PART = {"arms": ["rv4fd"], "tasks": ["reach"], "laws": ["ppc", "bsmc", "baek2016"], "quick": True, "workers": 1}


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    return asmc_pin.bench(out=tmp_path_factory.mktemp("bench") / "out", **PART)


def test_the_suite_is_five_arms_four_tasks_and_every_law_of_the_package():
    suite = load_suite()
    assert (len(suite.arms), len(suite.tasks)) == (5, 4)
    assert {table["law"] for table in suite.laws.values()} == set(CONTROLLERS)
    assert len(suite.cells) == 20 * len(CONTROLLERS)
    assert suite.whole
    assert suite.scope() == ""


@pytest.mark.parametrize("task", load_suite().tasks)
@pytest.mark.parametrize("arm", load_suite().arms)
def test_every_problem_can_be_built_and_its_motion_stays_within_the_arms_limits(arm, task):
    experiment = cell_experiment(load_suite(), arm, task, "baek2016")
    built, experiment_arm = experiment.build_controllers(), experiment.build_arm()
    assert built["baek2016"].nv == experiment_arm.nv
    drawn = draws_of(experiment)
    for draw in range(4):
        tables = drawn.tables(drawn.quantities(draw))
        one = experiment.replace(**{**tables, "sweep": None, "tune": None})
        motion = one.setpoints()[1]
        assert np.all(motion.q >= experiment_arm.lower)
        assert np.all(motion.q <= experiment_arm.upper)
        assert np.all(np.abs(motion.v) <= experiment_arm.velocity_limit)


def test_all_laws_of_a_problem_have_the_same_plant_draws_limit_and_start_of_the_search():
    suite = load_suite()
    given = [cell_experiment(suite, "ur5", "push", law) for law in suite.laws]
    first = given[0]
    for other in given[1:]:
        assert other.replace(controllers=first.controllers).to_toml() == first.to_toml()
        assert draws_of(other).quantities(3) == draws_of(first).quantities(3)
    assert first.tune.limits.torque_noise == [0.01 * x for x in suite.arms["ur5"]["effort"]]


def test_every_law_had_the_same_budget(done):
    assert np.all(done.findings.trials == load_suite().tables["quick"]["trials"])
    assert all(cell.held_out.size == load_suite().tables["quick"]["held_out"] for cell in done.cells)


def test_the_hash_of_the_conditions_stands_in_every_result_and_laws_are_no_part_of_it(done, tmp_path):
    sha256 = load_suite().sha256
    assert done.to_json_dict()["sha256"] == sha256
    assert json.loads((done.out / "provenance.json").read_text())["suite"]["sha256"] == sha256
    assert sha256[:16] in (done.out / "summary.md").read_text()
    (tmp_path / "mine.toml").write_text(f'extends = "{DEFAULT}"\nlaws.Mine = {{ law = "ppc", filter_hz = 40.0 }}\n')
    assert load_suite(tmp_path / "mine.toml").sha256 == sha256


def test_a_part_says_that_it_is_none_of_the_suite(done):
    lines = done.lines()
    assert lines[0].startswith("a part of asmc-bench-1")
    assert "1 of 5 arms, 1 of 4 tasks" in "\n".join(lines)
    assert "8 candidates a law in the place of 64" in "\n".join(lines)


def test_what_is_there_is_not_run_again_and_the_result_is_the_same_bytes(done, tmp_path):
    def stop(what, _share):
        if what == "1 of 3 cells":
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        asmc_pin.bench(out=tmp_path / "cut", progress=stop, **PART)
    written = list((tmp_path / "cut" / "cells").iterdir())
    assert len(written) == 1
    before = written[0].stat().st_mtime_ns
    asmc_pin.bench(out=tmp_path / "cut", **PART)
    assert written[0].stat().st_mtime_ns == before
    assert files_of(tmp_path / "cut") == files_of(done.out)


@pytest.mark.long
def test_workers_change_nothing(done, tmp_path):
    asmc_pin.bench(out=tmp_path / "two", **{**PART, "workers": 2})
    assert files_of(tmp_path / "two") == files_of(done.out)


def test_a_damaged_or_stale_cell_is_run_again(done, tmp_path):
    asmc_pin.bench(out=tmp_path / "out", **{**PART, "laws": ["ppc"]})
    (cell,) = (tmp_path / "out" / "cells").iterdir()
    whole = cell.read_bytes()
    for bad in (whole[:40], whole.replace(b'"key": "', b'"key": "0')):
        cell.write_bytes(bad)
        asmc_pin.bench(out=tmp_path / "out", **{**PART, "laws": ["ppc"]})
        assert cell.read_bytes() == whole


def files_of(folder):
    return {
        path.relative_to(folder).as_posix(): path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_file() and path.name != "provenance.json"
    }


# A law of one's own ---------------------------------------------------------------------------------------------------

WILD = """
import numpy as np
from dataclasses import dataclass
from asmc_pin import PerJoint, TdeLaw, TdeState

@dataclass(frozen=True, kw_only=True, eq=False)
class Wild(TdeLaw):
    push: PerJoint = PerJoint("how hard it leaves", "N·m/s", above=0.0)
    trial_step = None

    def step(self, state, sample, setpoint):
        torque, _, state = self.pole_placement(state, sample, setpoint)
        return np.full_like(torque, np.inf), state
"""


def test_a_law_of_ones_own_joins_by_one_line_and_one_that_always_fails_ranks_last(tmp_path):
    (tmp_path / "wild_law.py").write_text(WILD)
    (tmp_path / "mine.toml").write_text(f'extends = "{DEFAULT}"\nlaws.Wild = {{ law = "wild_law:Wild", push = 2.0 }}\n')
    found = asmc_pin.bench(tmp_path / "mine.toml", tmp_path / "out", **{**PART, "laws": ["ppc", "Wild"]})
    ppc, wild = (next(cell for cell in found.cells if cell.law == law) for law in ("ppc", "Wild"))
    assert math.isfinite(ppc.figure)
    assert wild.figure == math.inf
    assert not wild.kept
    assert wild.failed == wild.held_out.size
    assert [found.findings.laws[k] for k in found.findings.order] == ["ppc", "Wild"]
    assert found.to_json_dict()["laws"]["Wild"]["figures"] == {"rv4fd reach": None}
    assert "Wild: no gains that were tried kept the limit in rv4fd reach" in bench_lines(found.findings)


# What is made of the cells --------------------------------------------------------------------------------------------


def made(law, arm, task, held_out, kept=True, over=0):
    held_out = np.array(held_out, dtype=float)
    return CellResult(arm, task, law, 8, {"ks": 8.0}, kept, 1.0, held_out, held_out, over)


def findings():
    """Three laws on four problems: the second is best everywhere but for one failure, the third twice the first."""
    suite = load_suite().part(arms=["rv4fd", "ur5"], tasks=["smooth", "push"], laws=["ppc", "bsmc", "baek2016"])
    cells = []
    for i, (arm, task) in enumerate((arm, task) for arm in suite.arms for task in suite.tasks):
        cells.append(made("ppc", arm, task, [1.0, 1.0, 1.0]))
        cells.append(made("bsmc", arm, task, [0.5, math.inf, math.inf] if i == 3 else [0.5, 0.5, math.inf]))
        cells.append(made("baek2016", arm, task, [2.0, 2.0, 2.0], kept=i != 0))
    return findings_of(suite, cells)


def test_a_failure_is_infinite_and_counts_in_ranks():
    found = findings()
    assert found.figures.tolist()[1] == [0.5, 0.5, 0.5, math.inf]
    assert found.figures.tolist()[2] == [math.inf, 2.0, 2.0, 2.0]
    assert [mean.rank for mean in found.ranks] == [1.75, 1.5, 2.75]
    assert found.lost.tolist() == [0, 1, 1]
    assert found.failed.sum(axis=1).tolist() == [0, 5, 0]


def test_the_shifted_means_of_a_law_over_arms_and_tasks_are_scipys_and_infinite_after_a_failure():
    suite = load_suite().part(arms=["rv4fd", "ur5"], tasks=["smooth", "push"], laws=["ppc", "bsmc"])
    figures = [1e-5, 2e-3, 4e-2, 0.3]
    problems = [(arm, task) for arm in suite.arms for task in suite.tasks]
    cells = [made("ppc", *each, [x]) for each, x in zip(problems, figures, strict=True)]
    cells += [made("bsmc", *each, [x], kept=x > 1e-4) for each, x in zip(problems, figures, strict=True)]
    found = findings_of(suite, cells)
    mean, smooth, push = (stats.gmean(np.array(x) + 1e-5) - 1e-5 for x in (figures, figures[::2], figures[1::2]))
    assert found.means().tolist() == [pytest.approx(mean, rel=1e-12), math.inf]
    assert found.means("push").tolist() == [pytest.approx(push, rel=1e-12)] * 2
    table = mean_table(found)
    assert table.header == ["law", "smooth [rad]", "push [rad]", "all [rad]"]
    rows = {row[0]: row[1:] for row in table.rows}
    assert [float(x) for x in rows["ppc"]] == pytest.approx([smooth, push, mean], rel=0.01)
    assert rows["bsmc"] == ["∞", rows["ppc"][1], "∞"]
    told = bench_json(found, cells)["laws"]
    assert told["ppc"]["shifted_mean"] == pytest.approx(mean, rel=1e-12)
    assert told["bsmc"]["shifted_mean"] is None
    assert told["bsmc"]["shifted_mean_of_task"] == {"smooth": None, "push": pytest.approx(push, rel=1e-12)}


def test_it_is_said_plainly_who_fails_where_and_where_the_proposed_law_stands():
    found = findings()
    lines = "\n".join(bench_lines(found))
    assert "bsmc: most held-out trials failed in ur5 push" in lines
    assert "baek2016: no gains that were tried kept the limit in rv4fd smooth" in lines
    assert "the proposed law, baek2016: place 3 of 3 by mean rank" in lines
    assert "failed in 1 of 4 problems" in lines
    table = {row[0]: row[1:] for row in problem_table(found).rows}
    assert table["bsmc"][3] == "failed"
    assert table["baek2016"][:2] == ["limit", "4.00"]


def test_a_cell_is_the_same_after_it_was_written_and_read():
    cell = made("ppc", "ur5", "push", [1.0, math.inf], kept=False, over=1)
    again = from_json(json.loads(json.dumps(cell.to_json_dict(), allow_nan=False)))
    assert again.held_out.tolist() == [1.0, math.inf]
    assert (again.kept, again.over, again.figure) == (False, 1, math.inf)


# What is refused ------------------------------------------------------------------------------------------------------


def test_mistakes_are_told(tmp_path):
    with pytest.raises(ExperimentError, match="there is no suite 'asmc-bench-9', neither a file nor a shipped one"):
        load_suite("asmc-bench-9")
    with pytest.raises(ParameterError, match="did you mean 'ur5'"):
        load_suite().part(arms=["ur55"])
    mine = tmp_path / "mine.toml"
    for text, said in (
        ('extends = "asmc-bench-1"\ntrials = 9\n', "trials"),
        ('extends = "nothing"\n', "must name a shipped suite"),
        ('extends = "asmc-bench-1"\nlaws.ppc = { law = "ppc" }\n', "has a law of that name"),
        ('extends = "asmc-bench-1"\nlaws.Mine = 3\n', "each is a table"),
    ):
        mine.write_text(text)
        with pytest.raises(ExperimentError, match=said):
            load_suite(mine)
    (tmp_path / "thesis").mkdir()
    (tmp_path / "thesis" / "one.txt").write_text("years of work")
    with pytest.raises(ResultError, match="holds files that are no benchmark"):
        asmc_pin.bench(out=tmp_path / "thesis", **PART)


def test_surely_is_said_of_all_pairs_at_once_and_one_pair_by_itself_is_told_as_such():
    """ppc has twice the proposed law's figure everywhere; bsmc is far ahead in a few problems only."""
    suite = load_suite().part(laws=["ppc", "bsmc", "baek2016"])
    ahead = [
        0.2 + 0.01 * j if j < 5 else 1.0 + 0.002 * j * (-1) ** j for j in range(len(suite.arms) * len(suite.tasks))
    ]
    cells = []
    for (arm, task), small in zip(((a, t) for a in suite.arms for t in suite.tasks), ahead, strict=True):
        for law, figure in (("ppc", 2.0), ("bsmc", small), ("baek2016", 1.0)):
            cells.append(made(law, arm, task, [figure] * 3))
    found = findings_of(suite, cells)
    pairs = dict(found.verdicts_on("baek2016"))
    assert pairs["bsmc"].certain
    assert pairs["bsmc"].p > 0.05
    lines = bench_lines(found)
    assert "baek2016 is surely better than ppc" in lines
    assert "baek2016 is worse than bsmc (pair by pair, not adjusted for all pairs at once)" in lines
    assert {row[0]: row[-1] for row in pair_table_of(found, "baek2016").rows} == {"ppc": "yes", "bsmc": "pair"}
