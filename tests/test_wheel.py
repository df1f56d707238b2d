"""The built wheel gives the same commands without the checkout."""

import os
import subprocess
import sys
import sysconfig
import venv
from pathlib import Path

import pytest
from paths import REPOSITORY
from short_experiment import SHORT

ROOT = REPOSITORY


@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    """Path of `asmc-pin` in a fresh environment that sees the installed dependencies, but not the checkout."""
    work = tmp_path_factory.mktemp("wheel")
    pip = [sys.executable, "-m", "pip", "--disable-pip-version-check"]
    offline = ["--quiet", "--no-index", "--no-build-isolation", "--no-deps"]
    build = [*pip, "wheel", *offline, "--wheel-dir", str(work), str(ROOT)]
    subprocess.run(build, check=True, timeout=300)
    (wheel,) = work.glob("asmc_pin-*.whl")
    venv.create(work / "env", with_pip=False)
    python = work / "env" / "bin" / "python"
    install = [*pip, "--python", str(python), "install", "--quiet", "--no-index", "--no-deps", str(wheel)]
    subprocess.run(install, check=True, timeout=300)
    # What is installed, without the checkout that an editable install adds: .pth files are not read a second time.
    site = next((work / "env" / "lib").glob("python*/site-packages"))
    here = Path(sysconfig.get_paths()["purelib"])
    (site / "dependencies.pth").write_text("\n".join(p for p in sys.path if Path(p).is_relative_to(here)) + "\n")
    return work / "env" / "bin" / "asmc-pin"


def run(command, *arguments, cwd):
    environment = {k: v for k, v in os.environ.items() if k not in ("PYTHONPATH", "VIRTUAL_ENV")}
    return subprocess.run(
        [str(command), *arguments], cwd=cwd, capture_output=True, text=True, timeout=300, env=environment, check=False
    )


def test_the_wheel_imports_from_its_own_environment(installed, tmp_path):
    done = run(installed.parent / "python", "-c", "import asmc_pin; print(asmc_pin.__file__)", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert Path(done.stdout.strip()).is_relative_to(installed.parent.parent)


@pytest.mark.long
def test_the_wheel_carries_arms_and_experiments(installed, tmp_path):
    arms = run(installed, "arms", cwd=tmp_path)
    assert arms.returncode == 0, arms.stderr
    assert "two_link" in arms.stdout
    assert "rv4fd" in arms.stdout
    done = run(installed, "verify", "two_link", "--mbar", "0.01", "--along", "baek2016_simulation_smooth", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "unrefuted" in done.stdout


@pytest.mark.long
def test_the_wheel_compares(installed, tmp_path):
    experiment = tmp_path / "short.toml"
    experiment.write_text(SHORT)
    done = run(installed, "compare", str(experiment), cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "results" / "short" / "report.html").stat().st_size > 100_000
