"""Experiment files: what they build, and what is said about mistakes."""

import copy
import json
import re
import textwrap
import tomllib

import jsonschema
import numpy as np
import pytest
from paths import REPOSITORY

from asmc_pin.condition import lemma1_norm
from asmc_pin.controllers import CONTROLLERS, Baek2016
from asmc_pin.disk.resources import shipped
from asmc_pin.errors import ArmError, ExperimentError
from asmc_pin.experiment import (
    Experiment,
    experiment_names,
    experiment_schema,
    load_experiment,
    load_law,
)
from asmc_pin.experiment.toml_keys import ExperimentTables
from asmc_pin.experiment.toml_text import parse_toml, write_toml
from asmc_pin.parameters import parameters_of
from asmc_pin.references import REFERENCES, check_reference

ROOT = REPOSITORY
DATA = {
    "name": "small",
    "arm": {"source": "two_link"},
    "period": 0.001,
    "duration": 0.05,
    "plant": {"friction": {"coulomb": [1.0, 2.0]}, "effort_limit": [90.0, float("inf")]},
    "reference": {"kind": "quintic", "start": [0.3, 0.2], "targets": [[0.31, 0.19]], "move": 0.05},
    "defaults": {"mbar": [0.01, 0.02], "ks": 5.0, "beta": 4.0, "epsilon": 0.1},
    "controllers": {
        "PPC": {"law": "ppc"},
        "Stiff": {"law": "ppc", "beta": 40.0},
        "Proposed": {"law": "baek2016", "phi": 40, "alpha": [0.6, 1.5]},
    },
}


def changed(path, value):
    """The experiment above with the value at a dotted path replaced; None takes the key away."""
    data = copy.deepcopy(DATA)
    *parents, last = path.split(".")
    table = data
    for key in parents:
        table = table.setdefault(key, {})
    if value is None:
        del table[last]
    else:
        table[last] = value
    return data


def message_of(data, build=None, **options):
    def attempt():
        experiment = Experiment.from_dict(data, origin="file.toml", **options)
        return getattr(experiment, build)() if build else None

    with pytest.raises(ExperimentError) as caught:
        attempt()
    return str(caught.value)


def test_an_experiment_builds_what_it_describes():
    experiment = Experiment.from_dict(DATA)
    assert experiment.build_arm().joint_names == ("joint_1", "joint_2")
    plant = experiment.build_plant()
    assert plant.effort_limit.tolist() == [90.0, np.inf]
    assert plant.friction.coulomb.tolist() == [1.0, 2.0]
    assert np.all(plant.friction.viscous == 0.0)
    time, wanted = experiment.setpoints()
    assert time.shape == (51,)
    assert time[-1] == pytest.approx(0.05)
    assert wanted.q[0].tolist() == [0.3, 0.2]
    assert wanted.q[-1] == pytest.approx([0.31, 0.19])


def test_defaults_go_to_the_laws_that_take_them_and_give_way_to_a_laws_own():
    laws = Experiment.from_dict(DATA).build_controllers()
    assert list(laws) == ["PPC", "Stiff", "Proposed"]
    assert laws["PPC"].beta == 4.0
    assert laws["Stiff"].beta == 40.0
    assert not hasattr(laws["PPC"], "epsilon")
    assert isinstance(laws["Proposed"], Baek2016)
    assert laws["Proposed"].epsilon == 0.1
    assert laws["Proposed"].period == 0.001
    assert laws["Proposed"].alpha.tolist() == [0.6, 1.5]


def test_the_urdfs_friction_and_limits_hold_unless_told_otherwise():
    plant = Experiment.from_dict(changed("plant", {})).build_plant()
    assert plant.friction.coulomb.tolist() == [50.0, 50.0]
    assert np.all(np.isinf(plant.effort_limit))


@pytest.mark.parametrize(
    ("path", "value", "expected"),
    [
        ("perod", 0.1, "perod: unknown key: did you mean 'period'?"),
        ("period", None, "period: is missing"),
        ("period", "fast", "period: should be a valid number, got 'fast'"),
        ("period", True, "period: should be a valid number, got True"),
        ("period", float("nan"), "period: should be"),
        ("duration", -1.0, "duration: should be greater than 0, got -1.0"),
        ("duration", 2e-8, "duration: 2e-08 s is less than one control period of 0.001 s"),
        ("seed", 1.5, "seed: should be a valid integer, got 1.5"),
        ("name", "a/b", "name: got 'a/b'; expected letters, digits"),
        ("arm", 7, "arm: must be a table, got 7"),
        ("arm.sorce", "ur5", "arm.sorce: unknown key: did you mean 'source'?"),
        ("arm.payload", {"mas": 1.0}, "arm.payload.mas: unknown key: did you mean 'mass'?"),
        ("arm.payload", -1.0, "arm.payload.mass: should be greater than or equal to 0, got -1.0"),
        ("arm.armature", [0.1, -0.1], "arm.armature: must be a number of 0 or more"),
        ("arm.lock", {"joint_2": "loose"}, "arm.lock: of joint 'joint_2' must be an angle"),
        ("arm.gravity", [0.0, 9.81], "arm.gravity: list should have at least 3 items"),
        ("plant.substep", 4, "plant.substep: unknown key: did you mean 'substeps'?"),
        ("plant.substeps", 0, "plant.substeps: should be greater than or equal to 1, got 0"),
        ("plant.start", "hold", "plant.start: should be 'holding' or 'relaxed', got 'hold'"),
        ("plant.friction", {"coulom": 1.0}, "plant.friction.coulom: unknown key: did you mean 'coulomb'?"),
        ("plant.friction", {"coulomb": -1.0}, "plant.friction.coulomb: got -1.0; it must be at least 0 N·m"),
        (
            "plant.friction",
            {"coulomb": [[1.0, 1.0]]},
            "plant.friction.coulomb: must be a number, or a list with one for",
        ),
        ("plant.effort_limit", [90.0, 0.0], "plant.effort_limit: must be a positive number (inf for no limit)"),
        ("plant.q0", ["a", 0.0], "plant.q0: must be a finite number, or a list with one for each joint"),
        ("metrics.cutof_hz", 1.0, "metrics.cutof_hz: unknown key: did you mean 'cutoff_hz'?"),
        ("metrics.settling_band", 0.0, "metrics.settling_band: must be a positive number"),
        ("reference.kind", None, "reference.kind: is missing; one of quintic, ramps"),
        ("reference.kind", "quintc", "reference.kind: there is no kind 'quintc': did you mean 'quintic'?"),
        ("reference.kind", ["quintic"], "reference.kind: there is no kind ['quintic']"),
        ("reference.stat", [0.0, 0.0], "reference.stat: unknown key of kind 'quintic': did you mean 'start'?"),
        ("reference.move", None, "reference.move: is missing"),
        ("reference.move", -1.0, "reference.move: got -1.0; it must be above 0 s"),
        ("defaults.bet", 1.0, "defaults.bet: no law takes this parameter: did you mean 'beta'?"),
        ("defaults.period", 0.1, "defaults.period: stands once, at the top of the file"),
        ("defaults.beta", -1.0, "defaults.beta: got -1.0; it must be above 0 1/s"),
        ("defaults.ks", None, "controllers.PPC.ks: is missing; give it here, or in [defaults]"),
        ("controllers", {}, "controllers: dictionary should have at least 1 item"),
        ("controllers.law", "ppc", "controllers.law: a law stands in a table of its own, [controllers.LABEL]"),
        ("controllers.PPC.law", None, "controllers.PPC.law: is missing; one of ppc, bsmc"),
        ("controllers.PPC.law", "pcp", "controllers.PPC.law: there is no law 'pcp': did you mean 'ppc'?"),
        ("controllers.PPC.bta", 1.0, "controllers.PPC.bta: unknown parameter of law 'ppc': did you mean 'beta'?"),
        ("controllers.PPC.period", 0.1, "controllers.PPC.period: stands once, at the top of the file"),
        ("controllers.Stiff.beta", [1.0, 2.0], "controllers.Stiff.beta: got [1.0, 2.0]; expected one number"),
        ("controllers.Proposed.alpha", "big", "controllers.Proposed.alpha: got 'big'"),
    ],
)
def test_a_mistake_is_named_by_the_path_of_its_key(path, value, expected):
    message = message_of(changed(path, value))
    assert expected in message
    assert message.startswith("file.toml: ")


def test_all_mistakes_are_listed_at_once_and_the_first_is_the_errors_key():
    data = changed("perod", 1.0)
    data["plant"]["start"] = "hold"
    data["controllers"]["PPC"]["bta"] = 1.0
    with pytest.raises(ExperimentError) as caught:
        Experiment.from_dict(data, origin="file.toml")
    lines = str(caught.value).splitlines()
    assert lines[0] == "file.toml: 3 mistakes"
    assert [line.split(":")[0].strip() for line in lines[1:]] == ["plant.start", "perod", "controllers.PPC.bta"]
    assert caught.value.key == "plant.start"


def test_a_default_that_is_wrong_for_many_laws_is_reported_once():
    assert message_of(changed("defaults.mbar", "heavy")).count("mbar") == 1


@pytest.mark.parametrize(
    ("path", "value", "build"),
    [
        ("defaults.mbar", [0.1, 0.2, 0.3], "build_controllers"),
        ("controllers.Proposed.alpha", [0.6], "build_controllers"),
        ("plant.friction", {"viscous": [1.0, 1.0, 1.0]}, "build_plant"),
        ("plant.effort_limit", [1.0, 1.0, 1.0], "build_plant"),
        ("plant.q0", [0.0], "build_plant"),
        ("metrics.settling_band", [0.1, 0.1, 0.1], "metric_settings"),
        ("metrics.torque_rate_limit", [1e3, 1e3, 1e3], "metric_settings"),
    ],
)
def test_a_list_of_the_wrong_length_is_told_the_arms_joints(path, value, build):
    data = changed(path, value)
    key = path if not isinstance(value, dict) else f"{path}.viscous"
    message = message_of(data, build)
    count = len(value) if isinstance(value, list) else 3
    assert f"{key}: {count} values given, but two_link has 2 joints: joint_1, joint_2" in message


def test_a_reference_for_other_joints_is_told_the_arms_joints():
    data = changed("reference", {"kind": "quintic", "start": [0.0], "targets": [[1.0]], "move": 1.0})
    message = message_of(data, "build_reference")
    assert "reference: moves 1 joints, but two_link has 2 joints: joint_1, joint_2" in message


def test_what_does_not_fit_the_arm_is_named_by_its_key():
    assert "arm.lock: no joint 'joint_9'" in message_of(changed("arm.lock", {"joint_9": 0.0}), "build_arm")
    assert "arm.armature: 3 values given" in message_of(changed("arm.armature", [0.1, 0.1, 0.1]), "build_arm")
    with pytest.raises(ArmError, match="ur55"):
        Experiment.from_dict(changed("arm.source", "ur55")).build_arm()


@pytest.mark.parametrize(
    ("text", "line", "shown"),
    [
        ('name = "a"\nperiod 0.1\n', 2, "period 0.1"),
        ("[plant]\nsubsteps = 1\nsubsteps = 2\n", 3, "substeps = 2"),
        ("[controllers.PPC]\nlaw = ppc\n", 2, "law = ppc"),
        ('name = "a"\nks = [1.0,\n', 2, "ks = [1.0,"),
    ],
)
def test_broken_toml_is_answered_with_the_line(tmp_path, text, line, shown):
    path = tmp_path / "broken.toml"
    path.write_text(text)
    with pytest.raises(ExperimentError) as caught:
        load_experiment(path)
    assert f"broken.toml is not valid TOML, line {line}: " in str(caught.value)
    assert str(caught.value).endswith(shown)


def test_a_file_that_is_no_text_is_no_experiment(tmp_path):
    path = tmp_path / "picture.toml"
    path.write_bytes(b"\x89PNG\xff\xfe")
    with pytest.raises(ExperimentError, match="is not text in UTF-8"):
        load_experiment(path)


def test_an_unknown_experiment_is_answered_with_the_nearest(tmp_path):
    with pytest.raises(ExperimentError, match="neither a file nor a shipped one; did you mean 'panda_pick'"):
        load_experiment("panda_pik")
    with pytest.raises(ExperimentError, match="is a folder, an experiment is a TOML file"):
        load_experiment(tmp_path)


def test_toml_that_is_written_reads_back_as_it_was():
    data = copy.deepcopy(DATA)
    data["controllers"]['a "b" \\ \t é \x7f'] = {"law": "ppc", "filter_hz": 1e-300, "flag": True, "none": []}
    data["reference"]["nested"] = [[1, 2.5], [float("inf"), -0.0]]
    data["list_of_tables"] = [{"a": 1, "b c": "x"}]
    assert parse_toml(write_toml(data), "text") == data


def test_the_text_of_a_file_is_kept_until_something_is_changed(tmp_path):
    path = tmp_path / "mine.toml"
    text = "# why\n" + write_toml(DATA)
    path.write_text(text)
    experiment = load_experiment(path)
    assert experiment.to_toml() == text
    shorter = experiment.replace(duration=0.02)
    assert shorter.duration == 0.02
    assert parse_toml(shorter.to_toml(), "text") == {**DATA, "duration": 0.02}
    assert experiment.duration == 0.05
    with pytest.raises(ExperimentError, match="duration: should be greater than 0"):
        experiment.replace(duration=0.0)


def test_paths_are_looked_for_beside_the_file(tmp_path, monkeypatch):
    (tmp_path / "here").mkdir()
    (tmp_path / "here" / "path.csv").write_text("t,q1,q2\n0,0,0\n0.02,0.01,0\n0.04,0.02,0.01\n0.06,0,0.01\n")
    (tmp_path / "here" / "mine.urdf").write_text((shipped("urdf") / "two_link" / "two_link.urdf").read_text())
    data = changed("reference", {"kind": "csv", "path": "path.csv"})
    data["arm"] = "mine.urdf"
    (tmp_path / "here" / "mine.toml").write_text(write_toml(data))
    monkeypatch.chdir(tmp_path)
    experiment = load_experiment("here/mine.toml")
    assert experiment.build_arm().name == "mine"
    assert experiment.setpoints()[1].q[20].tolist() == pytest.approx([0.01, 0.0])


LAW = """
class MyLaw:
    def __init__(self, stiffness, damping=1.0):
        self.stiffness, self.damping = stiffness, damping

    def init(self, sample):
        return None

    def step(self, state, sample, setpoint):
        return self.stiffness * (setpoint.q - sample.q) + self.damping * (setpoint.v - sample.v), state


class NoLaw:
    pass
"""


@pytest.fixture
def own(tmp_path):
    (tmp_path / "my_law.py").write_text(LAW)
    return tmp_path


def own_data(**table):
    return changed("controllers.Mine", {"law": "my_law:MyLaw", "stiffness": 9.0, **table})


def test_a_law_of_ones_own_takes_its_own_parameters_and_those_shared_ones_that_it_knows(own):
    data = own_data()
    data["defaults"]["damping"] = 3.0
    law = Experiment.from_dict(data, folder=own).build_controllers()["Mine"]
    assert (law.stiffness, law.damping) == (9.0, 3.0)


@pytest.mark.parametrize(
    ("table", "expected"),
    [
        (
            {"stifness": 1.0},
            "controllers.Mine.stifness: unknown parameter of law 'my_law:MyLaw': did you mean 'stiffness'?",
        ),
        ({"law": "my_law:MyLow"}, "has no class 'MyLow'; did you mean 'MyLaw'?"),
        ({"law": "json:Law"}, "has no class 'Law'; nor any other class with a method 'step'"),
        ({"law": "my_law:NoLaw"}, "'my_law:NoLaw' is no control law: it has no method init and no step"),
        ({"law": "my_lav:MyLaw"}, "there is no module 'my_lav'; looked for my_lav.py in"),
        ({"law": "my_law.py:MyLaw"}, "is a file; a law is named by its module, 'my_law:MyLaw'"),
        ({"law": "my_law:"}, "controllers.Mine.law: 'my_law:' is not of the form 'my_module:MyLaw'"),
    ],
)
def test_mistakes_about_a_law_of_ones_own_are_named(own, table, expected):
    assert expected in message_of(own_data(**table), folder=own)


def test_a_law_whose_start_ends_the_process_is_a_mistake_of_the_experiment_and_no_fault_of_ours(own):
    (own / "gone.py").write_text(
        LAW.replace("def init(self, sample):", "def init(self, sample):\n        raise SystemExit(0)")
    )
    experiment = Experiment.from_dict(own_data(law="gone:MyLaw"), folder=own)
    with pytest.raises(ExperimentError, match=r"controllers\.Mine: init raised SystemExit: 0"):
        experiment.build_controllers()


def test_a_folder_that_was_searched_is_named_once(own, monkeypatch):
    monkeypatch.chdir(own)
    assert message_of(own_data(law="my_lav:MyLaw"), folder=own).count(str(own)) == 1


def test_a_run_that_no_memory_holds_is_refused_before_it_starts():
    message = message_of(changed("duration", 1e12))
    assert "duration: 1e+12 s are" in message
    assert "at most 1e+07" in message


def test_a_law_of_ones_own_whose_module_fails_says_why(tmp_path):
    (tmp_path / "failing_law.py").write_text("import no_such_thing\n")
    message = message_of(changed("controllers.Mine", {"law": "failing_law:Law"}), folder=tmp_path)
    assert "the module 'failing_law' cannot be imported: No module named 'no_such_thing'" in message


def test_two_experiments_may_each_have_a_module_of_the_same_name(tmp_path):
    for folder, value in (("a", 1), ("b", 2)):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "twin_law.py").write_text(LAW.replace("damping=1.0", f"damping={value}"))
    for folder, value in (("a", 1), ("b", 2), ("a", 1)):
        assert load_law("twin_law:MyLaw", tmp_path / folder)(1.0).damping == value


@pytest.mark.parametrize(
    "name",
    [
        "demo",
        "panda_pick",
        "ur5_full_plant",
        *(f"baek2016_{x}" for x in ("simulation_smooth", "simulation_step", "experiment")),
    ],
)
def test_shipped_experiments_build_and_their_arm_can_follow_the_reference(name):
    assert name in experiment_names()
    experiment = load_experiment(name)
    assert experiment.name == name
    arm, plant = experiment.build_arm(), experiment.build_plant()
    assert experiment.build_controllers()
    warnings = check_reference(
        experiment.build_reference(),
        arm,
        experiment.duration,
        experiment.period,
        coulomb=np.broadcast_to(plant.friction.coulomb, (arm.nv,)),
        viscous=np.broadcast_to(plant.friction.viscous, (arm.nv,)),
        effort_limit=plant.effort_limit,
    )
    assert warnings == []


def test_the_smooth_reference_shows_the_norm_range_that_the_paper_prints():
    experiment = load_experiment("baek2016_simulation_smooth")
    _, wanted = experiment.setpoints()
    size = np.degrees(np.abs(wanted.q)).max(axis=0)
    assert size == pytest.approx([160.0, 60.0], abs=1e-6)
    norm = lemma1_norm(experiment.build_arm().mass_matrix(wanted.q), np.array([0.01, 0.01]))
    assert f"{norm.min():.4f} {norm.max():.4f}" == "0.9869 0.9886"


def test_the_other_references_of_the_paper_stay_inside_its_figures():
    _, step = load_experiment("baek2016_simulation_step").setpoints()
    assert np.degrees(step.q).min() >= 20.0 - 1e-9
    assert np.degrees(step.q).max() <= 110.0 + 1e-9
    _, experiment = load_experiment("baek2016_experiment").setpoints()
    assert np.degrees(experiment.q).min() >= -1e-9
    assert np.degrees(experiment.q).max() <= 80.0
    assert np.all(experiment.q[0] == 0.0)
    assert np.all(experiment.v[0] == 0.0)


def test_the_papers_files_carry_the_printed_parameters():
    for name in ("baek2016_simulation_smooth", "baek2016_simulation_step"):
        law = load_experiment(name).build_controllers()["Proposed"]
        assert (law.period, law.beta, law.epsilon) == (0.001, 1.0, 0.015)
        assert law.mbar.tolist() == [0.01, 0.01]
        assert law.ks.tolist() == [1.0, 1.0]
        assert law.phi.tolist() == [4000.0, 3000.0]
        assert law.alpha.tolist() == [0.60, 1.57]
    law = load_experiment("baek2016_experiment").build_controllers()["Proposed"]
    assert (law.period, law.beta, law.epsilon, law.threshold) == (0.004, 20.0, 35.0, 1e-4)
    assert law.mbar.tolist() == [0.07, 0.12]
    assert law.ks.tolist() == [20.0, 20.0]
    assert law.phi.tolist() == [4e5, 3.6e5]
    assert law.alpha.tolist() == [300.0, 200.0]


@pytest.mark.parametrize("name", ["demo", "panda_pick"])
def test_the_mbar_of_a_shipped_experiment_is_not_refuted_by_a_search(name):
    experiment = load_experiment(name)
    arm, (low, high) = experiment.build_arm(), experiment.build_arm().box
    q = low + (high - low) * np.random.default_rng(1).random((4000, arm.nv))
    assert lemma1_norm(arm.mass_matrix(q), np.array(experiment.defaults["mbar"])).max() < 0.93


@pytest.mark.parametrize("path", sorted(shipped("experiments").glob("*.toml")), ids=lambda path: path.stem)
def test_shipped_experiments_name_the_schema_and_are_valid_under_it(path):
    text = path.read_text(encoding="utf-8")
    assert text.startswith("#:schema experiment.schema.json\n")
    jsonschema.validate(tomllib.loads(text), experiment_schema())


@pytest.mark.parametrize(
    ("path", "value"),
    [
        ("perod", 1.0),
        ("period", -1.0),
        ("plant.friction", {"coulom": 1.0}),
        ("reference.kind", "quintc"),
        ("reference.stat", [0.0, 0.0]),
        ("controllers.PPC.law", "pcp"),
        ("controllers.PPC.bta", 1.0),
        ("arm.sorce", "ur5"),
    ],
)
def test_an_editor_sees_the_mistakes_that_the_toolkit_sees(path, value):
    schema = experiment_schema()
    jsonschema.validate(DATA | {"plant": {}}, schema)
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(changed(path, value), schema)


def test_the_schema_knows_every_parameter_of_every_law_and_reference():
    text = json.dumps(experiment_schema())
    for cls in (*CONTROLLERS.values(), *REFERENCES.values()):
        for name, item in parameters_of(cls).items():
            assert f'"{name}"' in text
            assert name == "period" or json.dumps(item.meaning)[1:-1] in text


def test_the_docs_show_every_key_and_an_experiment_that_builds():
    text = (ROOT / "docs" / "experiments.md").read_text(encoding="utf-8")
    for key in ExperimentTables.model_fields:
        assert f"`{key}" in text, key
    for name, field in ExperimentTables.model_fields.items():
        inner = field.annotation
        for key in getattr(inner, "model_fields", {}):
            assert f"`{name}.{key}`" in text, key
    (example,) = re.findall(r"```toml\n(.*?)```", text, re.DOTALL)
    experiment = Experiment.from_dict(tomllib.loads(example))
    assert set(experiment.build_controllers()) == {"PPC", "Proposed, quick"}
    assert experiment.setpoints()[1].q.shape == (2001, 6)
    experiment.build_plant()


def test_the_docs_list_every_shipped_experiment():
    table = (ROOT / "docs" / "experiments.md").read_text(encoding="utf-8").split("| shipped |")[1].split("\n\n")[0]
    for name in experiment_names():
        short = re.sub(r"_.*_", "_…_", name) if name.endswith("_reconciled") else name
        assert f"`{short}`" in table, name


def test_the_docs_show_the_messages_as_they_are():
    text = (ROOT / "docs" / "experiments.md").read_text(encoding="utf-8")
    data = changed("perod", 1.0)
    data["defaults"]["bet"] = 1.0
    data["controllers"]["PPC"]["gain"] = 1.0
    with pytest.raises(ExperimentError) as caught:
        Experiment.from_dict(data, origin="mine.toml")
    shown = re.search(r"```\nasmc-pin: (mine.toml: 3 mistakes\n.*?)```", text, re.DOTALL)[1]
    assert sorted(textwrap.dedent(shown).split("\n")) == sorted(f"{caught.value}\n".split("\n"))


def test_a_law_of_ones_own_that_ends_the_process_is_refused_like_one_that_raises(tmp_path):
    (tmp_path / "a_script.py").write_text("raise SystemExit(5)\n")
    message = message_of(changed("controllers.Mine", {"law": "a_script:Law"}), folder=tmp_path)
    assert "the module 'a_script' cannot be imported: SystemExit: 5" in message
    (tmp_path / "leaving.py").write_text(
        "class Law:\n    init = step = None.__init__\n    def __init__(self): raise SystemExit(3)\n"
    )
    message = message_of(changed("controllers.Mine", {"law": "leaving:Law"}), folder=tmp_path)
    assert "controllers.Mine: Law refuses these parameters: SystemExit: 3" in message
