"""Reading a result back: trajectories, the summary and where it came from; and a replay that opens offline."""

import tempfile
from pathlib import Path

import numpy as np

import asmc_pin

with tempfile.TemporaryDirectory() as folder:
    experiment = asmc_pin.load_experiment("demo").replace(name="quick", duration=0.2)
    asmc_pin.compare(experiment, out=Path(folder) / "quick")

    result = asmc_pin.load_result(Path(folder) / "quick")
    data = result.dataset  # of the first trial; dimensions controller, trial, time, joint; units as attributes
    error = np.degrees(np.abs(data.q_ref - data.q)).max(("trial", "time"))
    print(error.to_pandas().round(4), "\n")
    print(result.summary[["controller", "joint", "rms_error", "torque_rms"]].head(6), "\n")
    print(f"made with seed {result.experiment.seed} from the URDF {result.provenance['arm']['sha256'][:16]}…")

    page = asmc_pin.view(result, html=Path(folder) / "replay.html")
    print(f"replay: {page.name}, {page.stat().st_size / 1e6:.1f} MB")
