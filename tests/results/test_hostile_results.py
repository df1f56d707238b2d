"""A damaged or forged result is one message that names the file, whatever is inside; never a page of nonsense."""

import json
import random
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from hostile import asked, refusal, small_result

from asmc_pin.errors import ResultError
from asmc_pin.results.result_folder import load_result

FILES = ["trajectories.nc", "monitors.nc", "summary.parquet", "claims.parquet", "provenance.json", "experiment.toml"]


def without_hashes(result: Path) -> Path:
    """As a stranger would have it, who knows that a hash is compared where there is one."""
    path = result / "provenance.json"
    content = json.loads(path.read_text())
    del content["files"]
    path.write_text(json.dumps(content))
    return result


@pytest.mark.parametrize("name", FILES[:4])
def test_one_flipped_bit_is_found_though_no_format_would_notice(name: str, tmp_path: Path) -> None:
    result = small_result(tmp_path)
    path = result / name
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 1
    path.write_bytes(bytes(data))
    said = refusal("report", result)
    assert name in said
    assert "damaged or changed" in said


@pytest.mark.parametrize("name", FILES)
@pytest.mark.parametrize("damage", ["empty", "half", "all but a byte", "zeros", "noise", "text", "of another kind"])
def test_a_file_that_is_not_what_its_name_says_is_one_message(name: str, damage: str, tmp_path: Path) -> None:
    result = without_hashes(small_result(tmp_path))
    path = result / name
    data = path.read_bytes()
    path.write_bytes(
        {
            "empty": b"",
            "half": data[: len(data) // 2],
            "all but a byte": data[:-1] if name != "experiment.toml" else data[:-9],
            "zeros": bytes(len(data)),
            "noise": random.Random(0).randbytes(len(data)),
            "text": b"hello",
            "of another kind": (result / FILES[FILES.index(name) - 2]).read_bytes(),
        }[damage]
    )
    if (name, damage) == ("provenance.json", "all but a byte"):
        path.write_bytes(data[:-2])
    said = refusal("report", result)
    assert name in said
    assert "run the comparison again" in said


@pytest.mark.parametrize(
    "text",
    [
        "[]",
        "3",
        '"x"',
        "null",
        "[" * 100_000,
        '{"a": NaN}',
        '{"arm": 3}',
        '{"arm": {"sha256": 3}}',
        "9" * 10_000,
        "\ud800",
    ],
)
def test_a_provenance_that_is_none_is_one_message(text: str, tmp_path: Path) -> None:
    result = small_result(tmp_path)
    (result / "provenance.json").write_bytes(text.encode("utf-8", "surrogatepass"))
    assert "provenance.json" in refusal("report", result)


def replaced(name: str, values: object, dims: tuple[str, ...] | None = None) -> Callable[[h5py.File], None]:
    def change(file: h5py.File) -> None:
        old = file[name]
        scales = [old.dims[i][0].name for i in range(old.ndim) if len(old.dims[i])] if dims is None else list(dims)
        del file[name]
        kind = h5py.string_dtype() if isinstance(np.asarray(values).ravel()[0], str) else None
        new = file.create_dataset(name, data=np.asarray(values, dtype=object) if kind else values, dtype=kind)
        for i, scale in enumerate(scales):
            new.dims[i].attach_scale(file[scale])

    return change


def emptied(name: str) -> Callable[[h5py.File], None]:
    def change(file: h5py.File) -> None:
        file[name][...] = np.nan

    return change


def set_to(name: str, index: object, value: object) -> Callable[[h5py.File], None]:
    def change(file: h5py.File) -> None:
        values = file[name][()]
        values[index] = value
        file[name][...] = values

    return change


def deleted(name: str) -> Callable[[h5py.File], None]:
    return lambda file: file.__delitem__(name)


def claiming(shape: tuple[int, ...], dtype: str = "f8", chunks: tuple[int, ...] | None = None):
    """A dataset that takes no room in the file and a great deal in memory."""

    def change(file: h5py.File) -> None:
        del file["q"]
        file.create_dataset("q", shape=shape, dtype=dtype, chunks=chunks or True, compression="gzip", fillvalue=0)

    return change


def group(file: h5py.File) -> None:
    file.create_group("more")


def many(file: h5py.File) -> None:
    for i in range(300):
        file[f"x{i}"] = 1.0


def warned(value: object) -> Callable[[h5py.File], None]:
    return lambda file: file.attrs.__setitem__("warnings", value)


TAMPERED = {
    "no q": (deleted("q"), "no variable 'q'"),
    "no time": (deleted("time"), "trajectories.nc"),
    "no status": (deleted("status"), "no variable 'status'"),
    "NaN times": (emptied("time"), "times are not finite"),
    "times that go back": (set_to("time", 5, -1.0), "increasing"),
    "times that start late": (set_to("time", 0, -0.5), "from 0"),
    "an end that is no number": (emptied("end_time"), "end_time"),
    "a reference that is no number": (set_to("q_ref", (0, 0), np.nan), "q_ref"),
    "positions beyond all": (set_to("q", (0, 0, 3, 0), 1e300), "beyond"),
    "a joint twice": (set_to("joint", 1, "joint_1"), "same name"),
    "another joint": (set_to("joint", 1, "elbow"), "joint"),
    "a joint of no kind": (set_to("joint_kind", 1, "spherical"), "joint_kind"),
    "another controller": (set_to("controller", 0, "Other"), "not those of its experiment"),
    "a label with a code": (set_to("controller", 0, "PPC\x1b[31m"), r"\x1b[31m"),
    "a label with a line": (set_to("controller", 0, "PPC\nasmc-pin: holds"), r"\x0a"),
    "a status of its own": (set_to("status", (0, 0), "winner"), "status"),
    "a text of 1 MB": (set_to("law", 0, "x" * 1_000_000), "characters"),
    "text for numbers": (replaced("end_time", [["a"], ["b"]]), "end_time"),
    "numbers for text": (replaced("status", [[1.0], [2.0]]), "status"),
    "other axes": (replaced("q_ref", np.zeros((2, 51)), ("joint", "time")), "axes"),
    "another number of trials": (replaced("trial", np.arange(3)), "trajectories.nc"),
    "a trial that is not 0": (set_to("trial", 0, 7), "numbered from 0"),
    "complex numbers": (replaced("end_time", np.zeros((2, 1), complex)), "neither numbers nor text"),
    "a terabyte": (claiming((2, 1, 10**9, 60)), "GB"),
    "a huge chunk": (claiming((2, 1, 51, 10**7), "f8", (2, 1, 51, 10**7)), "GB"),
    "five axes": (claiming((1, 1, 1, 1, 1)), "dimensions"),
    "a group": (group, "group"),
    "300 variables": (many, "variables"),
    "warnings that are numbers": (warned(np.zeros(3)), "warnings"),
    "a million warnings": (warned("x" * 1_000_000), "warnings"),
}


@pytest.mark.parametrize("case", TAMPERED)
def test_trajectories_that_no_comparison_leaves_are_one_message(case: str, tmp_path: Path) -> None:
    result = without_hashes(small_result(tmp_path))
    change, told = TAMPERED[case]
    with h5py.File(result / "trajectories.nc", "a") as file:
        change(file)
    said = refusal("view", result, "--html", tmp_path / "page.html")
    assert told in said
    assert len(said) < 2000
    assert not (tmp_path / "page.html").exists()


def test_the_longest_result_is_a_choice_of_the_caller(tmp_path: Path) -> None:
    result = small_result(tmp_path)
    assert load_result(result).dataset.sizes["time"] == 51
    with pytest.raises(ResultError, match="unpacks to"):
        load_result(result, largest=1000)
    assert load_result(result, largest=float("inf")).dataset.sizes["time"] == 51


def rows(change: Callable[[pd.DataFrame], pd.DataFrame]) -> Callable[[Path], None]:
    def write(path: Path) -> None:
        table = change(pd.read_parquet(path).copy())
        pq.write_table(pa.Table.from_pandas(table, preserve_index=False), path)

    return write


TABLES = {
    "no rows": rows(lambda table: table.iloc[:0]),
    "a row too few": rows(lambda table: table.iloc[1:]),
    "a row twice": rows(lambda table: pd.concat([table.iloc[:1], table.iloc[:-1]])),
    "rows by the thousand": rows(lambda table: pd.concat([table] * 2_000)),
    "no controllers": rows(lambda table: table.drop(columns="controller")),
    "other controllers": rows(lambda table: table.assign(controller="Other")),
    "numbers for controllers": rows(lambda table: table.assign(controller=1.0)),
    "no status": rows(lambda table: table.assign(status=None)),
    "another status": rows(lambda table: table.assign(status="winner")),
    "text for trials": rows(lambda table: table.assign(trial="first")),
    "a trial of its own": rows(lambda table: table.assign(trial=7)),
    "lists": rows(lambda table: table.assign(more=[[1.0]] * len(table))),
    "dates": rows(lambda table: table.assign(more=pd.Timestamp("2020-01-01"))),
    "300 columns": rows(
        lambda table: pd.concat([table] * 20, axis=1).set_axis([f"x{i}" for i in range(20 * table.shape[1])], axis=1)
    ),
    "a text of 1 MB": rows(lambda table: table.assign(arm="x" * 1_000_000, reason="x" * 1_000_000)),
}


@pytest.mark.parametrize("name", ["summary.parquet", "claims.parquet"])
@pytest.mark.parametrize("case", TABLES)
def test_a_table_that_no_comparison_leaves_is_one_message(case: str, name: str, tmp_path: Path) -> None:
    result = without_hashes(small_result(tmp_path))
    TABLES[case](result / name)
    said = refusal("report", result)
    assert name in said
    assert len(said) < 2000


def test_a_metric_that_is_text_is_one_message(tmp_path: Path) -> None:
    result = without_hashes(small_result(tmp_path))
    rows(lambda table: table.assign(rms_error="small"))(result / "summary.parquet")
    assert "'rms_error' holds something else" in refusal("report", result)


def test_monitors_of_another_run_are_one_message(tmp_path: Path) -> None:
    result = without_hashes(small_result(tmp_path))
    with h5py.File(result / "monitors.nc", "a") as file:
        set_to("time", 5, 9.0)(file)
    assert "axis 'time' is not that of trajectories.nc" in refusal("report", result)


def test_a_result_of_another_experiment_is_one_message(tmp_path: Path) -> None:
    result = without_hashes(small_result(tmp_path))
    path = result / "experiment.toml"
    text = path.read_text()
    for old, new, told in (
        ("duration = 0.05", "duration = 0.07", "along 'time'"),
        ("[controllers.Wild]", "[controllers.Tame]", "not those of its experiment"),
        ('[controllers.Wild]\nlaw = "ppc"\nbeta = 900.0\nks = 900.0', "", "along 'controller'"),
        ('arm = "two_link"', 'arm = "ur5"', "ur5"),
    ):
        assert old in text
        path.write_text(text.replace(old, new))
        assert told in refusal("report", result)


def read(result: Path) -> str:
    """What is wrong with a result, empty where nothing is."""
    try:
        load_result(result)
    except ResultError as error:
        return str(error)
    return ""


def test_random_damage_is_one_message_or_no_damage(tmp_path: Path) -> None:
    """Bytes of the binary files, changed at random: what is not noticed leaves the page whole."""
    good = without_hashes(small_result(tmp_path))
    generator = random.Random(5)
    statuses = set()
    for trial in range(40):
        name = FILES[trial % 4]
        data = bytearray((good / name).read_bytes())
        for _ in range(generator.choice([1, 3, 30])):
            data[generator.randrange(len(data) if trial % 8 < 4 else 2000)] = generator.choice([0, 1, 127, 255])
        kept = (good / name).read_bytes()
        (good / name).write_bytes(bytes(data))
        said = read(good)
        assert said == "" or name in said
        statuses.add(bool(said))
        (good / name).write_bytes(kept)
    assert statuses == {False, True}
    assert asked("report", good).status == 0


def test_an_experiment_that_is_not_the_one_that_ran_is_noticed(tmp_path: Path) -> None:
    result = small_result(tmp_path)
    path = result / "experiment.toml"
    text = path.read_text(encoding="utf-8")
    path.write_text(text.replace("duration = ", "duration =  ", 1), encoding="utf-8")
    with pytest.raises(ResultError, match=r"experiment\.toml: is damaged or changed"):
        load_result(result)
