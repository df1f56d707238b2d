"""What a sweep needs: the workers' memory against the number of trials, and how much faster two processes are than one.

    python benchmarks/sweep.py [--trials 1000 10000 100000] [--workers 2] [--readme]
    python benchmarks/sweep.py --speed 6000 [--readme]

Each trial is 2 s of the UR5 at 1 kHz under `ppc`, with a load of its own and friction of its own in every joint. Memory
is the peak of what each process had in RAM (VmHWM of /proc, so this part runs on Linux): of the workers the largest,
shared libraries counted in each. The ratio of the largest run over the smallest one says whether it grows.

Speed is trials per second by the clock, from the first block that was handed over to the last, so without what
starting, compiling and the page take; it wants idle processors.
"""

from __future__ import annotations

import argparse
import os
import platform
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from asmc_pin.experiment import Experiment, load_experiment

README = Path(__file__).with_name("README.md")
START = "from asmc_pin.cli import main; main()"
MB = 1e6


def experiment() -> Experiment:
    """The UR5 of `ur5_robustness`, for 2 s at 1 kHz under one law."""
    base = load_experiment("ur5_robustness")
    sweep = {name: base.sweep[name] for name in ("arm.payload", "plant.friction.coulomb")}
    plant = {"friction": base.variation.data["plant"]["friction"]}
    return base.replace(
        name="memory", period=1e-3, duration=2.0, plant=plant, sweep=sweep, controllers={"PPC": {"law": "ppc"}}
    )


def peak(pid: int) -> float:
    """Largest resident memory of a process so far, bytes; 0 once it is gone."""
    try:
        lines = Path(f"/proc/{pid}/status").read_text().splitlines()
        return next((1024.0 * float(line.split()[1]) for line in lines if line.startswith("VmHWM:")), 0.0)
    except OSError:
        return 0.0


def children(pid: int) -> list[int]:
    """Processes that a process has started and that run."""
    found = []
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = stat.read_text().rsplit(")", 1)[1].split()
        except OSError:
            continue
        if int(fields[1]) == pid:
            found.append(int(stat.parent.name))
    return found


def memory(trials: int, workers: int, folder: Path) -> dict[str, float]:
    """Peaks of one sweep, bytes, and its times, s."""
    file = folder / "memory.toml"
    file.write_text(experiment().to_toml())
    arguments = ["sweep", str(file), "--trials", str(trials), "--workers", str(workers), "--out", str(folder / "rows")]
    began, used = time.monotonic(), os.times()
    process = subprocess.Popen([sys.executable, "-c", START, *arguments], stdout=subprocess.DEVNULL)
    most = {"worker": 0.0, "sweep": 0.0}
    while process.poll() is None:
        most["sweep"] = max(most["sweep"], peak(process.pid))
        most["worker"] = max([most["worker"], *map(peak, children(process.pid))])
        time.sleep(0.5)
    if process.returncode:
        raise SystemExit(f"the sweep ended with status {process.returncode}")
    now = os.times()
    cpu = now.children_user + now.children_system - used.children_user - used.children_system
    rows = (folder / "rows" / "rows.parquet").stat().st_size
    return {**most, "wall": time.monotonic() - began, "cpu": cpu, "rows": float(rows)}


def rate(trials: int, workers: int, folder: Path) -> float:
    """Trials per second from the first block that is done to the last."""
    from asmc_pin.sweeping import sweep

    times: list[tuple[float, float]] = []

    def tell(what: str, share: float) -> None:
        if what != "writing":
            times.append((time.perf_counter(), share))

    sweep(experiment(), trials, folder / f"{workers}", workers=workers, progress=tell)
    done = [(at, share) for at, share in times if share > 0.0]
    return trials * (done[-1][1] - done[0][1]) / (done[-1][0] - done[0][0])


def write_table(lines: list[str], name: str) -> None:
    """Replace a table in the README."""
    text = README.read_text(encoding="utf-8")
    begin, end = f"<!-- from here: {name} -->", f"<!-- to here: {name} -->"
    head, rest = text.split(begin)
    README.write_text(f"{head}{begin}\n" + "\n".join(lines) + f"\n{end}{rest.split(end)[1]}", encoding="utf-8")


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--trials", type=int, nargs="+", default=[1000, 10_000])
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--speed", type=int, metavar="TRIALS", help="time one process and two instead")
    parser.add_argument("--readme", action="store_true", help="replace the table of benchmarks/README.md")
    options = parser.parse_args()
    print(f"{os.cpu_count()} processors, {platform.machine()}, load {os.getloadavg()[0]:.1f}")
    with tempfile.TemporaryDirectory() as folder:
        if options.speed:
            one, two = (rate(options.speed, workers, Path(folder)) for workers in (1, 2))
            lines = ["| processes | trials per s | ratio | goal |", "| ---: | ---: | ---: | ---: |"]
            lines += [f"| 1 | {one:.1f} | 1 |  |", f"| 2 | {two:.1f} | {two / one:.2f} | 1.8 |"]
        else:
            lines = [
                "| trials | largest worker, MB | over the first | sweep itself, MB | `rows.parquet`, MB | CPU, s |"
            ]
            lines += ["| ---: | ---: | ---: | ---: | ---: | ---: |"]
            first = 0.0
            for trials in options.trials:
                (Path(folder) / str(trials)).mkdir()
                found = memory(trials, options.workers, Path(folder) / str(trials))
                first = first or found["worker"]
                lines.append(
                    f"| {trials:,} | {found['worker'] / MB:.0f} | {found['worker'] / first:.2f} "
                    f"| {found['sweep'] / MB:.0f} | {found['rows'] / MB:.1f} | {found['cpu']:.0f} |"
                )
                print(lines[-1], flush=True)
    print("\n".join(lines))
    if options.readme:
        write_table(lines, "sweep-speed" if options.speed else "sweep-memory")


if __name__ == "__main__":
    main()
