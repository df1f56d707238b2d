"""To look at a stranger's result or motion runs no code that it names, and reads no file beside it without need."""

import os
from pathlib import Path

import h5py
import numpy as np
import pytest
from hostile import asked, refusal, small_result
from short_experiment import SHORT

from asmc_pin.errors import ExperimentError
from asmc_pin.experiment import load_experiment
from asmc_pin.results.result_folder import load_result

TRAP = """
from pathlib import Path
Path(__file__).with_name("sprung").write_text("this code ran")
from asmc_pin.controllers import CONTROLLERS
class MyLaw(CONTROLLERS["ppc"]): pass
"""
OWN = '\n[controllers.Own]\nlaw = "trap_of_a_stranger:MyLaw"\nanything = 1.0\n'


def trap(folder: Path) -> Path:
    """A module beside a file that names it as a law; whoever imports it leaves a file."""
    (folder / "trap_of_a_stranger.py").write_text(TRAP)
    return folder / "sprung"


def result_with_a_law_of_its_own(folder: Path) -> Path:
    """A stranger's result, whose second controller is now said to be code that lies beside it."""
    result = small_result(folder)
    text = (result / "experiment.toml").read_text()
    start = text.index("[controllers.Wild]")
    (result / "experiment.toml").write_text(text[:start] + OWN.replace("Own", "Wild"))
    (result / "provenance.json").write_text('{"experiment": {"folder": "' + str(result) + '"}}')
    return result


@pytest.mark.parametrize("command", ["report", "view"])
def test_looking_at_a_result_never_imports_the_law_that_it_names(command: str, tmp_path: Path, monkeypatch) -> None:
    result = result_with_a_law_of_its_own(tmp_path)
    sprung = trap(result)
    monkeypatch.chdir(result)
    page = result / "report.html" if command == "report" else tmp_path / "page.html"
    page.unlink(missing_ok=True)
    said = asked("report", result) if command == "report" else asked("view", result, "--html", page)
    assert said.status == 0, said
    assert "Wild" in page.read_text()
    assert not sprung.exists()


def test_verifying_along_an_experiment_never_imports_the_law_that_it_names(tmp_path: Path, monkeypatch) -> None:
    (tmp_path / "e.toml").write_text(SHORT + OWN)
    sprung = trap(tmp_path)
    monkeypatch.chdir(tmp_path)
    said = asked("verify", "two_link", "--mbar", "0.01", "--along", "e.toml")
    assert said.status == 0, said
    assert not sprung.exists()


def test_comparing_does_import_it_and_so_the_trap_can_spring(tmp_path: Path, monkeypatch) -> None:
    (tmp_path / "e.toml").write_text(SHORT + OWN)
    sprung = trap(tmp_path)
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ExperimentError, match=r"controllers\.Own"):
        load_experiment(tmp_path / "e.toml")
    assert sprung.read_text() == "this code ran"


def test_an_experiment_read_without_its_laws_says_so_when_it_is_to_run(tmp_path: Path) -> None:
    (tmp_path / "e.toml").write_text(SHORT + OWN)
    sprung = trap(tmp_path)
    looked_at = load_experiment(tmp_path / "e.toml", import_laws=False)
    assert looked_at.build_reference().nv == 2
    with pytest.raises(ExperimentError, match=r"controllers\.Own\.law: its law is code of somebody's own"):
        looked_at.build_controllers()
    with pytest.raises(ExperimentError, match="somebody's own"):
        looked_at.replace(duration=0.1).build_controllers()
    assert not sprung.exists()


def test_the_help_of_compare_says_that_it_runs_code() -> None:
    text = " ".join(asked("compare", "--help").out.replace("│", " ").split())
    assert "runs the code of a law" in text


def rewritten(path: Path, name: str, make) -> None:
    with h5py.File(path, "a") as file:
        del file[name]
        make(file)


def external(file: h5py.File) -> None:
    file.create_dataset("end_time", shape=(2, 1), dtype="f8", external=[("secret", 0, h5py.h5f.UNLIMITED)])


def virtual(file: h5py.File) -> None:
    layout = h5py.VirtualLayout(shape=(2, 1), dtype="f8")
    layout[:] = h5py.VirtualSource("secret.h5", "x", shape=(2, 1))
    file.create_virtual_dataset("end_time", layout)


def linked(file: h5py.File) -> None:
    file["end_time"] = h5py.ExternalLink("secret.h5", "x")


def soft(file: h5py.File) -> None:
    file["end_time"] = h5py.SoftLink("/time")


@pytest.mark.parametrize("way", [external, virtual, linked, soft])
def test_a_result_never_takes_its_numbers_from_another_file(way, tmp_path: Path, monkeypatch) -> None:
    result = small_result(tmp_path)
    monkeypatch.chdir(result)
    (result / "secret").write_bytes(np.zeros(2).tobytes())
    with h5py.File(result / "secret.h5", "w") as file:
        file["x"] = np.zeros((2, 1))
    (result / "provenance.json").write_text("{}")
    rewritten(result / "trajectories.nc", "end_time", way)
    said = refusal("report", result)
    assert "another file" in said or "points elsewhere" in said


def test_a_figure_that_is_a_link_out_of_the_result_is_not_put_into_a_page(tmp_path: Path) -> None:
    result = small_result(tmp_path)
    secret = tmp_path / "secret.png"
    secret.write_bytes(b"\x89PNG\r\n\x1a\nprivate")
    (result / "figures" / "extra.png").symlink_to(secret)
    assert "lies elsewhere" in refusal("report", result)
    (result / "figures" / "extra.png").unlink()
    (result / "figures" / "extra.png").write_text("not a picture")
    assert "is no PNG file" in refusal("report", result)


MESHES = ["file:///etc/passwd", "../../../../../../../etc/passwd", "package://etc/passwd", "/etc/passwd", "/dev/zero"]


@pytest.mark.parametrize("name", MESHES)
def test_only_what_is_named_like_a_mesh_is_opened_as_one(name: str, tmp_path: Path, monkeypatch) -> None:
    from asmc_pin.arms.sources.robot_files import RobotFiles

    opened: list[object] = []
    monkeypatch.setattr(Path, "is_file", opened.append)
    with pytest.raises(ValueError, match="is no mesh file"):
        RobotFiles(tmp_path, further=[tmp_path, Path("/")]).mesh(name)
    assert not opened


def test_a_mesh_that_is_a_pipe_or_a_device_is_not_read(tmp_path: Path) -> None:
    from asmc_pin.arms.sources.robot_files import RobotFiles
    from asmc_pin.viewer.drawing.meshes import load_mesh

    os.mkfifo(tmp_path / "pipe.stl")
    (tmp_path / "zero.stl").symlink_to("/dev/zero")
    for name in ("pipe.stl", "zero.stl"):
        with pytest.raises(FileNotFoundError):
            RobotFiles(tmp_path).mesh(name)
        with pytest.raises(ValueError, match="regular file"):
            load_mesh(tmp_path / name)


def test_nothing_in_the_package_unpickles() -> None:
    sources = Path(load_result.__code__.co_filename).parent.parent.rglob("*.py")
    texts = {path: path.read_text(encoding="utf-8") for path in sources}
    assert len(texts) > 100
    assert not [path for path, text in texts.items() if "pickle" in text.replace("allow_pickle=False", "")]
