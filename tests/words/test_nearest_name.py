"""Who mistypes a name is told the one that was meant, or all there are."""

import pytest

from asmc_pin import CONTROLLERS, METRICS, REFERENCES
from asmc_pin.arms import ARMS
from asmc_pin.words.nearest_name import near_names, nearest

REGISTERED = [tuple(names) for names in (CONTROLLERS, REFERENCES, METRICS, ARMS)]


def slips(name):
    """The name with one letter left out, doubled or taken for another, and with two that changed places."""
    for i in range(len(name)):
        yield name[:i] + name[i + 1 :]
        yield name[: i + 1] + name[i:]
        yield f"{name[:i]}#{name[i + 1 :]}"
    for i in range(len(name) - 1):
        yield name[:i] + name[i + 1] + name[i] + name[i + 2 :]


@pytest.mark.parametrize("known", REGISTERED, ids=["laws", "references", "metrics", "arms"])
def test_every_registered_name_is_offered_to_who_slips_in_one_letter_of_it(known):
    missed = {
        wrong: name
        for name in known
        if len(name) > 2  # half of two letters is no likeness
        for wrong in slips(name)
        if wrong not in known and name not in near_names(wrong, known)
    }
    assert not missed


@pytest.mark.parametrize("known", REGISTERED, ids=["laws", "references", "metrics", "arms"])
def test_a_name_in_the_wrong_capitals_is_offered_first_and_as_it_is_written(known):
    for name in known:
        assert near_names(name.swapcase(), known)[0] == name


def test_the_nearest_comes_first_and_three_are_offered_at_most():
    known = ["elbow_link", "elbow", "elbow_joint", "elbow_joints", "wrist"]
    assert near_names("elbow_join", known) == ["elbow_joint", "elbow_joints", "elbow_link"]
    assert nearest("elbow_join", known) == "did you mean 'elbow_joint' or 'elbow_joints' or 'elbow_link'?"


def test_names_that_differ_by_capitals_only_are_all_offered_but_no_more_than_three():
    assert near_names("kp", ["KP", "ki", "Kp"])[:2] == ["KP", "Kp"]
    assert near_names("kp", ["KP", "Kp", "kP", "kp"]) == ["KP", "Kp", "kP"]


def test_where_nothing_is_near_all_names_are_given_in_their_order():
    assert nearest("zzz", ["quintic", "csv"]) == "known are quintic, csv"
    assert nearest("zzz", ["quintic", "csv"], all_of="choose from") == "choose from quintic, csv"
    assert nearest("", ["quintic", "csv"]) == "known are quintic, csv"


def test_where_there_are_no_names_that_is_said():
    assert nearest("zzz", []) == "none is known here"


def test_names_that_can_be_read_once_only_are_all_given():
    assert nearest("zzz", iter(["quintic", "csv"])) == "known are quintic, csv"
    assert nearest("cvs", iter(["quintic", "csv"])) == "did you mean 'csv'?"
