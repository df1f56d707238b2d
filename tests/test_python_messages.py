"""Claims about what a Python session is told of arguments that cannot be: one message of the package, no bare error."""

import pytest

from asmc_pin import (
    AsmcPinError,
    agree,
    bounds,
    certify,
    check,
    compare,
    design,
    export,
    identify,
    load_arm,
    load_experiment,
    load_result,
    stability,
    suggest_gains,
    sweep,
    tune,
    verify,
)

ARM = load_arm("two_link")
VERBS = {
    "verify": lambda arm=ARM, **options: verify(arm, 0.02, samples=64, **options),
    "certify": lambda arm=ARM, **options: certify(arm, 0.02, **options),
    "design": lambda arm=ARM, **options: design(arm, explain=False, **options),
    "bounds": lambda arm=ARM, **options: bounds(arm, **options),
    "stability": lambda arm=ARM, **options: stability(arm, 0.02, 5.0, 5.0, 0.001, limits=False, **options),
    "suggest_gains": lambda arm=ARM, **options: suggest_gains(arm, 0.02, 0.001, **options),
}


@pytest.mark.parametrize("verb", VERBS)
def test_the_name_of_an_arm_in_its_place_is_answered_with_how_it_is_loaded(verb):
    with pytest.raises(AsmcPinError, match=r"'two_link' given, an Arm expected: load_arm\('two_link'\)"):
        VERBS[verb]("two_link")


@pytest.mark.parametrize("verb", VERBS)
@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"seed": -1}, "seed: -1 given, a whole number of 0 or more"),
        ({"seed": 1.5}, "seed: 1.5 given"),
        ({"box": [0.0, 1.0]}, r"box: \[0.0, 1.0\] given, joint to \(lower, upper\)"),
        ({"lock": 3}, "lock: 3 given, joint to one or more angles"),
    ],
)
def test_what_every_verb_takes_is_refused_in_the_same_words_by_each(verb, options, said):
    with pytest.raises(AsmcPinError, match=said):
        VERBS[verb](**options)


@pytest.mark.parametrize(
    ("verb", "options", "said"),
    [
        ("verify", {"tube_width": 0.1}, "give the motion with along"),
        ("verify", {"starts": -1}, "starts: -1 given"),
        ("verify", {"threads": 0}, "threads: 0 given"),
        ("verify", {"along": "demo"}, r"demo: no such file; an experiment goes as load_experiment"),
        ("design", {"level": "x"}, "level: 'x' given"),
        ("design", {"budget": None}, "budget: None given"),
        ("certify", {"gap": "x"}, "gap: '?x'? given"),
        ("certify", {"budget": "x"}, "budget: '?x'? given"),
        ("bounds", {"gap": "x"}, "gap: '?x'? given"),
        ("stability", {"law": "dob"}, "law: 'dob' given, a law expected"),
        ("suggest_gains", {"coulomb": -1.0}, "coulomb: got"),
        ("suggest_gains", {"speed": [1.0, 2.0, 3.0]}, "speed: got"),
    ],
)
def test_an_argument_of_one_verb_that_cannot_be_is_named_with_what_was_given(verb, options, said):
    with pytest.raises(AsmcPinError, match=said):
        VERBS[verb](**options)


@pytest.mark.parametrize("source", [None, 3, [], b"ur5"])
def test_what_is_neither_a_name_nor_a_path_is_no_arm(source):
    with pytest.raises(AsmcPinError, match="an arm's name or the path of a URDF expected"):
        load_arm(source)


def test_a_table_of_mbar_is_told_its_shape_and_not_that_two_are_not_two():
    with pytest.raises(AsmcPinError, match=r"shape \(1, 2\) given, 2 expected"):
        verify(ARM, [[0.1, 0.2]])


@pytest.mark.parametrize(
    "verb", [compare, tune, lambda name: sweep(name, 2), lambda name: export(name, "PPC", "out")], ids=range(4)
)
def test_the_name_of_an_experiment_in_its_place_is_answered_with_how_it_is_loaded(verb, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(AsmcPinError, match=r"'demo' given, an Experiment expected: load_experiment\('demo'\)"):
        verb("demo")
    with pytest.raises(AsmcPinError, match="None given, an Experiment expected; load_experiment makes one"):
        verb(None)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("verb", [agree, lambda name: identify(name, "log.csv")], ids=["agree", "identify"])
def test_verbs_about_an_arm_say_so_before_they_look_at_anything_else(verb):
    with pytest.raises(AsmcPinError, match=r"load_arm\('two_link'\)"):
        verb("two_link")


def test_a_folder_that_holds_a_result_is_answered_in_pythons_words(tmp_path):
    (tmp_path / "mine.txt").write_text("mine")
    for verb in (compare, lambda experiment, out: sweep(experiment, 1, out)):
        with pytest.raises(AsmcPinError, match="give another folder with out=") as told:
            verb(load_experiment("demo"), out=tmp_path)
        assert "--" not in str(told.value)
    assert [path.name for path in tmp_path.iterdir()] == ["mine.txt"]


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: load_experiment(None), "None given"),
        (lambda: load_result(3), "3 given"),
        (lambda: check(3), "3 given"),
        (lambda: sweep(load_experiment("demo"), "x"), "'x' given"),
        (lambda: export(load_experiment("demo"), "BSMC", None), "None given"),
        (lambda: stability(ARM, 0.02, 5.0, 5.0, 0.001, limits=False, sensor="x"), "'x' given"),
    ],
)
def test_what_is_no_name_number_or_sensor_is_answered_with_what_was_expected(call, said):
    with pytest.raises(AsmcPinError, match=said):
        call()
