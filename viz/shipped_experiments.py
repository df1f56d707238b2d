"""Every shipped experiment, run and replayed, its controllers side by side.

python viz/shipped_experiments.py [FOLDER [NAME …]]        default: results/gallery, all
"""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path

from asked import asked_folder

from asmc_pin import compare, load_experiment
from asmc_pin.experiment import experiment_names
from asmc_pin.results.result_folder import load_result
from asmc_pin.viewer import write_replay


def make(folder: Path, names: Sequence[str] = ()) -> dict[str, Path]:
    """Runs the experiments and writes the pages; their titles and files."""
    pages = {}
    for name in names or experiment_names():
        with tempfile.TemporaryDirectory() as scratch:
            result = load_result(compare(load_experiment(name), out=Path(scratch) / name).out)
            pages[name] = folder / f"experiment_{name}.html"
            write_replay(result, pages[name])
    return pages


if __name__ == "__main__":
    for page in make(*asked_folder(__doc__, names="shipped experiments; all by default")).values():
        print(page)
