"""The built wheel gives the same commands without the checkout."""

import os
import subprocess
import sys
import sysconfig
import venv
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent


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
    # A plain path in a .pth file is searched, but .pth files inside it (the editable install) are not read.
    site = next((work / "env" / "lib").glob("python*/site-packages"))
    (site / "dependencies.pth").write_text(sysconfig.get_paths()["purelib"] + "\n")
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


def test_the_wheel_carries_arms_and_experiments(installed, tmp_path):
    arms = run(installed, "arms", cwd=tmp_path)
    assert arms.returncode == 0, arms.stderr
    assert "two_link" in arms.stdout
    assert "rv4fd" in arms.stdout
    done = run(installed, "verify", "two_link", "--mbar", "0.01", "--along", "baek2016_simulation_smooth", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "unrefuted" in done.stdout


def test_the_wheel_compares(installed, tmp_path):
    experiment = tmp_path / "short.toml"
    experiment.write_text(
        """
name = "short"
arm = "two_link"
period = 0.001
duration = 0.05
[plant]
friction = { coulomb = 1.0, viscous = 0.1 }
[reference]
kind = "quintic"
times = [0.0, 0.05]
points = [[0.3, 0.2], [0.31, 0.21]]
[defaults]
mbar = 0.01
ks = 5.0
beta = 5.0
[controllers.PPC]
law = "ppc"
"""
    )
    done = run(installed, "compare", str(experiment), cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "results" / "short" / "report.html").stat().st_size > 100_000
