"""A URDF that lies, in one way or another, is refused with one message that says where, or loads as every reader
reads it."""

import codecs
from pathlib import Path

import pytest
from hostile import BODY, asked, chain, refusal, verify

from asmc_pin.arms import load_arm
from asmc_pin.errors import ArmError, AsmcPinError, ParameterError

ARM = chain(2)
DECLARED = '<?xml version="1.0" encoding="{}"?>\n'


def written(folder: Path, data: str | bytes, name: str = "arm.urdf") -> Path:
    path = folder / name
    path.write_bytes(data if isinstance(data, bytes) else data.encode())
    return path


# Python knows all of these by name: as text of several bytes a character, as no text, and as codes of other things.
FOREIGN = [
    "gbk",
    "big5",
    "shift_jis",
    "euc-kr",
    "utf-7",
    "utf-32",
    "idna",
    "punycode",
    "rot13",
    "hex",
    "base64",
    "zlib",
]
FOREIGN += ["unicode_escape", "raw_unicode_escape", "undefined", "uu", "bz2", "cp037", "klingon", "utf-8\0", "x" * 300]


@pytest.mark.parametrize("encoding", FOREIGN)
def test_an_encoding_that_is_not_read_is_named_in_one_message(encoding: str, tmp_path: Path) -> None:
    said = refusal(*verify(written(tmp_path, DECLARED.format(encoding) + ARM)))
    assert "UTF-8" in said or "not well-formed XML" in said
    assert len(said) < 800


@pytest.mark.parametrize(
    ("encoding", "codec", "mark"),
    [
        ("UTF-8", "utf-8", b""),
        ("utf-8", "utf-8", codecs.BOM_UTF8),
        ("utf-16", "utf-16-le", codecs.BOM_UTF16_LE),
        ("UTF-16", "utf-16-be", codecs.BOM_UTF16_BE),
        ("utf-16", "utf-16-le", b""),
        ("utf-16", "utf-16-be", b""),
        ("ISO-8859-1", "latin-1", b""),
        ("windows-1252", "cp1252", b""),
        ("us-ascii", "ascii", b""),
    ],
)
def test_an_arm_is_the_same_in_every_encoding_that_is_read(
    encoding: str, codec: str, mark: bytes, tmp_path: Path
) -> None:
    text = ARM.replace('name="j1"', 'name="jé1"' if codec != "ascii" else 'name="j1"')
    path = written(tmp_path, mark + (DECLARED.format(encoding) + text).encode(codec))
    arm = load_arm(path)
    assert arm.joint_names == ("j0", "jé1" if codec != "ascii" else "j1")
    assert arm.sha256 != load_arm(written(tmp_path, text, "plain.urdf")).sha256


def test_bytes_that_are_not_of_the_encoding_are_named_by_line(tmp_path: Path) -> None:
    said = refusal(*verify(written(tmp_path, ARM.encode().replace(b'name="j1"', b'name="j\xff1"'))))
    assert "line 3" in said
    assert "UTF-8" in said


@pytest.mark.parametrize("number", ["1e400", "inf", "nan", "0x10", "１２", "1_000", "1,5", "", "1e", "1d3", "--1"])
@pytest.mark.parametrize("place", ['<mass value="1"', 'ixx="0.1"', 'xyz="0 0 0.1"', 'xyz="0 1 0"'])
def test_a_number_that_is_none_is_named_with_its_place(number: str, place: str, tmp_path: Path) -> None:
    before, _, _ = place.rpartition('="')
    value = f"0 0 {number}" if "xyz" in place else number
    said = refusal(*verify(written(tmp_path, ARM.replace(place, f'{before}="{value}"'))))
    assert "in arm.urdf, line" in said


@pytest.mark.parametrize("number", ["1.", "+1", " 1 ", ".1e1", "1E0", "1.0000000000000000000000000000001"])
def test_a_number_means_the_same_to_every_reader(number: str, tmp_path: Path) -> None:
    plain = load_arm(written(tmp_path, ARM, "plain.urdf"))
    odd = load_arm(written(tmp_path, ARM.replace('<mass value="1"', f'<mass value="{number}"'), "odd.urdf"))
    assert (odd.tree.mass == plain.tree.mass).all()


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ('<mass value="1"', '<mass value="1e308"', "its mass is 1e+308 kg"),
        ('<mass value="1"', '<mass value="1e300"', "its mass is 1e+300 kg"),
        ('ixx="0.1" iyy="0.1"', 'ixx="1e300" iyy="1e300"', "its inertia has an entry of 1e+300"),
        ('xyz="0 0 0.1"', 'xyz="0 0 1e300"', "at most 1e+06 m are taken"),
        ("</joint>", '<dynamics friction="1e300"/></joint>', "its friction is 1e+300"),
    ],
)
def test_a_number_beyond_any_arm_is_named_and_not_what_overflows_from_it(
    old: str, new: str, told: str, tmp_path: Path
) -> None:
    said = refusal(*verify(written(tmp_path, ARM.replace(old, new, 1))))
    assert told in said
    assert "nothing resists" not in said


@pytest.mark.parametrize("mass", ["1e-40", "1e-300"])
def test_masses_too_far_apart_for_a_double_are_named_both(mass: str, tmp_path: Path) -> None:
    light = BODY.replace('value="1"', f'value="{mass}"').replace('"0.1"', f'"{mass}"')
    text = ARM.replace(f'<link name="l2">{BODY}', f'<link name="l2">{light}')
    said = refusal(*verify(written(tmp_path, text)))
    assert "joint 'j1'" in said
    assert f"a mass of {float(mass):.3g} kg" in said
    assert "'l1'" in said
    assert "nothing resists" not in said


def test_a_limit_that_stands_for_none_is_taken_as_undeclared(tmp_path: Path) -> None:
    arm = load_arm(
        written(tmp_path, ARM.replace('upper="1"', 'upper="1.7e308"').replace('lower="-1"', 'lower="-1e16"'))
    )
    assert (arm.upper == float("inf")).all()
    assert (arm.lower == -float("inf")).all()


@pytest.mark.parametrize("axis", ["1e300 0 1e300", "1e-320 0 0", "0 1e-200 0"])
def test_an_axis_is_a_direction_whatever_its_length(axis: str, tmp_path: Path) -> None:
    arm = load_arm(written(tmp_path, ARM.replace('xyz="0 1 0"', f'xyz="{axis}"')))
    assert abs((arm.tree.axis**2).sum(axis=1) - 1.0).max() < 1e-12


@pytest.mark.parametrize("what", ['name="j1"', 'name="l2"', 'name="r"'])
@pytest.mark.parametrize(
    ("hostile", "shown"),
    [
        ("&#x9b;31m", r"\x9b31m"),
        ("a&#10;asmc-pin: holds", r"a\x0aasmc-pin: holds"),
        ("a&#9;b", r"a\x09b"),
        ("\u202ejoint", r"\u202ejoint"),
        ("a\u2028b", r"a\u2028b"),
        ("a\ufeffb", r"a\ufeffb"),
        ("n" * 300, "300 characters"),
    ],
)
def test_a_name_that_a_terminal_would_obey_is_refused_and_shown_as_codes(
    what: str, hostile: str, shown: str, tmp_path: Path
) -> None:
    name = what.split('"')[1]
    text = ARM.replace(what, what.replace(name, hostile))
    text = text.replace(f'link="{name}"', f'link="{hostile}"')
    said = refusal(*verify(written(tmp_path, text)))
    assert shown in said
    assert "rename it" in said or "shorten it" in said


@pytest.mark.parametrize("name", ["[/joint_1]", "[bold]j[/]", "a|b", "<b>", "$x$", r"\frac", "größe", "关节", "a b"])
def test_a_plain_name_is_taken_as_it_is(name: str, tmp_path: Path) -> None:
    text = ARM.replace('name="j1"', f'name="{name.replace("<", "&lt;")}"')
    assert load_arm(written(tmp_path, text)).joint_names == ("j0", name)


def test_hostile_text_in_a_value_never_reaches_the_terminal_as_it_is(tmp_path: Path) -> None:
    for value in ("&#x9b;2J", "1&#10;asmc-pin: holds", "\u202e1"):
        said = refusal(*verify(written(tmp_path, ARM.replace('<mass value="1"', f'<mass value="{value}"', 1))))
        assert "is not a number" in said
        assert len(said.splitlines()) == 1


def test_no_message_ever_carries_a_control_character() -> None:
    told = str(AsmcPinError("a \x1b[31m name\r\nand \u202e a second line"))
    assert told == "a \\x1b[31m name\\x0d\nand \\u202e a second line"
    assert len(str(ArmError("x", "y" * 10**6))) < 3000
    assert str(ParameterError("a\x00b", "c")) == "a\\x00b: c"


@pytest.mark.parametrize("option", ["--payload", "--armature", "--lock", "--gravity", "--box", "--mbar"])
@pytest.mark.parametrize(
    "number", ["nan", "inf", "1e400", "1e300", "", "1_0", "１", "x", "1:", ":", "1:2:3", "2:1", "\x1b[31m"]
)
def test_a_number_on_the_command_line_that_is_none_is_refused_with_its_option(
    option: str, number: str, tmp_path: Path
) -> None:
    arm = written(tmp_path, ARM)
    value = {"--lock": f"j0={number}", "--box": f"j0=0:{number}", "--gravity": f"0,0,{number}"}.get(option, number)
    if (option, number) in {("--box", "1e300"), ("--mbar", "1e300")}:
        assert asked(*verify(arm), option, value).status in (0, 1, 2)
        return
    rest = [] if option == "--mbar" else ["--mbar", "0.01"]
    assert option.strip("-") in refusal("verify", arm, *rest, "--samples", "4", option, value)
