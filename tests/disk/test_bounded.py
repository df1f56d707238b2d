"""What has no end, or claims a great deal, is refused before it is read: bounded in memory, whatever it says."""

import os
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest
from hostile import BODY, asked, chain, refusal, small_result, verify
from short_experiment import SHORT

from asmc_pin.arms.urdf.magnitudes import MOVING_JOINTS
from asmc_pin.disk.reading import read_file, user_path
from asmc_pin.errors import AsmcPinError

GIGABYTE = 2**30


def endless(folder: Path, kind: str, suffix: str) -> Path:
    """A path at which there is no end, no beginning, no file, or far too much."""
    path = folder / f"endless{suffix}"
    if kind == "device":
        path.symlink_to("/dev/zero")
    elif kind == "nothing":
        path.symlink_to("/dev/null")
    elif kind == "pipe":
        os.mkfifo(path)
    elif kind == "folder":
        path.mkdir()
    else:
        with path.open("wb") as file:
            file.truncate(3 * GIGABYTE)
    return path


KINDS = ["device", "nothing", "pipe", "folder", "sparse"]


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("command", ["arm", "along", "recording", "compare", "path"])
def test_no_command_reads_what_has_no_end(command: str, kind: str, tmp_path: Path) -> None:
    if command == "arm":
        said = refusal(*verify(endless(tmp_path, kind, ".urdf")))
    elif command == "compare":
        said = refusal("compare", endless(tmp_path, kind, ".toml"), "--out", tmp_path / "out")
    elif command == "path":
        endless(tmp_path, kind, ".csv")
        text = SHORT.replace('kind = "multisine"', 'kind = "csv"\npath = "endless.csv"')
        lines = [line for line in text.splitlines() if line.split(" ")[0] not in ("offset", "amplitude", "frequency")]
        (tmp_path / "e.toml").write_text("\n".join(lines))
        said = refusal("verify", "two_link", "--mbar", "0.01", "--along", tmp_path / "e.toml")
    else:
        path = endless(tmp_path, kind, ".csv" if command == "recording" else ".toml")
        said = refusal("verify", "two_link", "--mbar", "0.01", "--along", path)
    assert "endless" in said
    words = {
        "folder": "a folder" if command != "recording" else "a directory",
        "pipe": "is a pipe",
        "sparse": "MB",
    }.get(kind, "no file but a device")
    assert words in said


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(
    "name",
    ["experiment.toml", "trajectories.nc", "monitors.nc", "summary.parquet", "claims.parquet", "provenance.json"],
)
def test_no_file_of_a_result_is_read_that_has_no_end(name: str, kind: str, tmp_path: Path) -> None:
    result = small_result(tmp_path)
    (result / name).unlink()
    endless(tmp_path, kind, "").rename(result / name)
    said = refusal("report", result)
    assert name in said


def test_a_pipe_that_nobody_writes_to_is_not_waited_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(AsmcPinError, match="is a pipe"):
        read_file(tmp_path / "pipe", 100, "a URDF", AsmcPinError)


def test_a_file_may_be_as_large_as_its_kind_and_no_larger(tmp_path: Path) -> None:
    path = tmp_path / "f"
    path.write_bytes(b"x" * 100)
    assert read_file(path, 100, "a URDF", AsmcPinError) == b"x" * 100
    with pytest.raises(AsmcPinError, match="is not read"):
        read_file(path, 99, "a URDF", AsmcPinError)


@pytest.mark.parametrize("name", ["~nobody_of_that_name/x.urdf", "x" * 5000, "a\x1bb"])
def test_a_path_that_no_system_takes_is_a_message(name: str) -> None:
    refusal(*verify(Path(name)))
    refusal("compare", name)
    refusal("report", name)
    assert user_path("~nobody_of_that_name/x") == Path("~nobody_of_that_name/x")


LAUGHS = "".join(f'<!ENTITY {chr(98 + i)} "{("&" + chr(97 + i) + ";") * 10}">' for i in range(12))
SPHERES = '<visual><geometry><sphere radius="0.1"/></geometry></visual>' * 20_000
HUGE = {
    "400 joints": (lambda: chain(400), "400 moving joints"),
    "joints above the bound": (lambda: chain(MOVING_JOINTS + 1), f"at most {MOVING_JOINTS}"),
    "50,000 links": (lambda: chain(50_000), "is not read"),
    "2,000 links": (lambda: chain(2_000), "2001 links"),
    "200,000 attributes": (
        lambda: chain(2).replace("<robot", "<robot " + " ".join(f'a{i}="1"' for i in range(200_000))),
        "attributes",
    ),
    "a name of 100 kB": (lambda: chain(2, name="n" * 100_000), "100001 characters"),
    "elements in one another": (lambda: chain(2, extra="<a>" * 300_000 + "</a>" * 300_000), "deep"),
    "a text of 15 MB": (lambda: chain(2, extra="x" * 15_000_000), "not well-formed XML"),
    "an attribute of 12 MB": (lambda: chain(2).replace("0 1 0", "0 " * 6_000_000), "not well-formed XML"),
    "a number of a million digits": (lambda: chain(2).replace('value="1"', f'value="{"1" * 10**6}"'), "not a finite"),
    "a billion laughs": (lambda: f'<!DOCTYPE r [<!ENTITY a "ha">{LAUGHS}]><robot name="&m;"/>', "entity 'a'"),
    "a million elements": (lambda: chain(2, extra="<a/>" * 1_000_000), "more than 200000 elements"),
    "25 MB": (lambda: chain(2, extra=" " * 25_000_000), "is not read"),
    "20,000 spheres": (lambda: chain(2).replace("</link>", SPHERES + "</link>", 1), None),
    "190,000 elements": (lambda: chain(2, extra="<a/>" * 190_000), None),
}


@pytest.mark.long
def test_a_huge_urdf_is_answered_or_refused_within_two_gigabytes(tmp_path: Path) -> None:
    """One process for all of them; the bound is on its address space, libraries and compiled kernels included."""
    for i, (make, _) in enumerate(HUGE.values()):
        (tmp_path / f"{i}.urdf").write_text(make())
    code = f"""
        import contextlib, io, resource, sys
        from asmc_pin.arms import load_arm
        from asmc_pin.errors import ArmError
        from asmc_pin.viewer import draw
        import trimesh.creation
        base = int(open("/proc/self/statm").read().split()[0]) * resource.getpagesize()
        resource.setrlimit(resource.RLIMIT_AS, (base + 2 * {GIGABYTE},) * 2)
        for i in range({len(HUGE)}):
            try:
                arm = load_arm(f"{tmp_path}/{{i}}.urdf")
                draw(arm, 1000)
                print(i, "loaded")
            except ArmError as error:
                print(i, str(error).replace(chr(10), " "))
    """
    ran = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", textwrap.dedent(code)], capture_output=True, text=True, timeout=500
    )
    assert ran.returncode == 0, ran.stderr[-2000:]
    said = ran.stdout.splitlines()
    assert len(said) == len(HUGE)
    for (name, (_, told)), line in zip(HUGE.items(), said, strict=True):
        assert (told or "loaded") in line, name
        assert len(line) < 3000


TOML = {
    "a key of 100,000 parts": ("a" + ".a" * 100_000 + " = 1", "parts"),
    "a table of 100,000 parts": ("[" + "a." * 100_000 + "a]", "parts"),
    "quoted and spaced": ("'a' . " * 100_000 + "a = 1", "parts"),
    "lists in one another": ("x = " + "[" * 100_000 + "]" * 100_000, "deep"),
    "tables in one another": ("x = " + "{a=" * 100_000, "deep"),
    "an integer of 10,000 digits": ("seed = " + "9" * 10_000, "TOML"),
    "a hexadecimal one": ("seed = 0x" + "f" * 10_000, "64 bits"),
    "a date": (SHORT + "\nextra = 2020-01-01", "a date or a time"),
    "a string of 4 MB": (SHORT.replace('"short"', '"' + "s" * 4_000_000 + '"'), "name"),
    "1,000 controllers": (SHORT + "".join(f"[controllers.c{i}]\nlaw = 'ppc'\n" for i in range(1_000)), "at most 100"),
    "1,000 unknown keys": ("".join(f"k{i} = 1\n" for i in range(1_000)) + SHORT, "1000 mistakes"),
    "100,000 keys": ("".join(f"k{i} = 1\n" for i in range(100_000)), "no experiment has as many"),
    "bad UTF-8": (b'name = "\xff"', "not text in UTF-8"),
    "UTF-16": ("name = 'a'".encode("utf-16"), "not text in UTF-8"),
    "NUL": ('name = "a\0"', "not valid TOML"),
    "10 MB": ("#" * 10_000_000, "is not read"),
}


@pytest.mark.parametrize("case", TOML)
def test_a_huge_or_odd_experiment_is_refused_with_one_message(case: str, tmp_path: Path) -> None:
    text, told = TOML[case]
    path = tmp_path / "e.toml"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    said = refusal("verify", "two_link", "--mbar", "0.01", "--along", path)
    assert told in said
    assert len(said) < 100_000
    assert len(said.splitlines()) < 50


@pytest.mark.parametrize(
    "name", ["..", "../up", "a/b", "-rf", ".hidden", "a\\u0000b", "a\\nb", "\\u202ea", "x" * 101, ""]
)
def test_a_name_that_is_no_name_of_a_folder_is_refused(name: str, tmp_path: Path) -> None:
    path = tmp_path / "e.toml"
    path.write_text(SHORT.replace('"short"', f'"{name}"'))
    assert "name" in refusal("compare", path)


@pytest.mark.parametrize("label", ["a\\u001b[31m", "a\\nasmc-pin: holds", "\\u202ea", " ", "x" * 201])
def test_a_label_that_a_terminal_would_obey_is_refused(label: str, tmp_path: Path) -> None:
    path = tmp_path / "e.toml"
    path.write_text(SHORT.replace("[controllers.PPC]", f'[controllers."{label}"]'))
    assert "label" in refusal("compare", path, "--out", tmp_path / "out")


CSV = {
    "empty": b"",
    "a header alone": b"t,q1,q2\n",
    "one row": b"t,q1,q2\n0,1,2\n",
    "NaN": b"t,q1,q2\n0,nan,2\n1,1,2\n",
    "infinite": b"t,q1,q2\n0,1,2\n1,1e400,2\n",
    "an integer beyond floats": b"t,q1,q2\n0,1,2\n1," + b"9" * 400 + b",2\n",
    "text": b"t,q1,q2\n0,1,2\n1,x,2\n",
    "time that stands": b"t,q1,q2\n0,1,2\n0,1,2\n",
    "time that goes back": b"t,q1,q2\n1,1,2\n0,1,2\n",
    "NaN time": b"t,q1,q2\n0,1,2\nnan,1,2\n",
    "a short row": b"t,q1,q2\n0,1,2\n1,1\n",
    "a long row": b"t,q1,q2\n0,1,2\n1,1,2,3\n",
    "rows longer than the header": b"t,q1,q2\n0,1,2,3\n1,1,2,3\n",
    "an open quote": b't,q1,q2\n0,"1,2\n1,1,2\n',
    "NUL": b"t,q1,q2\n0,1\0,2\n1,1,2\n",
    "a huge field": b"t,q1,q2\n0," + b"1" * 200_000 + b",2\n1,1,2\n",
    "UTF-16": "t,q1,q2\n0,1,2\n1,1,2\n".encode("utf-16"),
    "no text": bytes(range(256)) * 20,
    "ten million columns": b"t" + b",q" * 10_000_000 + b"\n",
    "other digits": "t,q1,q2\n0,1,２\n1,1,2\n".encode(),
    "a name with a code": b"t,q\x1b[31m1,q2\n0,1,2\n1,1,2\n",
}


@pytest.mark.parametrize("case", CSV)
@pytest.mark.parametrize("role", ["recording", "reference"])
def test_a_damaged_csv_is_refused_with_one_message(case: str, role: str, tmp_path: Path) -> None:
    path = tmp_path / "f.csv"
    path.write_bytes(CSV[case])
    if role == "reference":
        text = SHORT.replace('kind = "multisine"', 'kind = "csv"\npath = "f.csv"')
        lines = [line for line in text.splitlines() if line.split(" ")[0] not in ("offset", "amplitude", "frequency")]
        path = tmp_path / "e.toml"
        path.write_text("\n".join(lines))
    said = refusal("verify", "two_link", "--mbar", "0.01", "--along", path)
    assert "f.csv" in said
    assert len(said) < 3000


@pytest.mark.parametrize("step", ["5e-324", "1e-300", "1e-200"])
@pytest.mark.parametrize("spline", ["cubic", "quintic"])
def test_rows_too_close_for_a_spline_are_a_message(step: str, spline: str, tmp_path: Path) -> None:
    rows = "".join(f"{i * float(step)!r},{i % 2},{(i // 2) % 2}\n" for i in range(8))
    (tmp_path / "f.csv").write_text(f"t,q1,q2\n{rows}")
    text = SHORT.replace('kind = "multisine"', f'kind = "csv"\npath = "f.csv"\nspline = "{spline}"')
    lines = [line for line in text.splitlines() if line.split(" ")[0] not in ("offset", "amplitude", "frequency")]
    (tmp_path / "e.toml").write_text("\n".join(lines))
    assert "f.csv" in refusal("verify", "two_link", "--mbar", "0.01", "--along", tmp_path / "e.toml")


def test_links_without_end_cost_no_square_of_their_number(tmp_path: Path) -> None:
    """A thousand links behind one joint, all of them fixed: the bound itself is answered."""
    path = tmp_path / "long.urdf"
    path.write_text(chain(999, kind="fixed", body=BODY))
    assert asked(*verify(path)).status in (0, 1)
