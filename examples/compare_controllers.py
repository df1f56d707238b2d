"""Which controller is better? An experiment made in Python, run for four laws, its figures as a table."""

import tempfile
from pathlib import Path

import asmc_pin

# Half a second of the shipped experiment, so that this is quick.
experiment = asmc_pin.load_experiment("demo").replace(name="quick", duration=0.5)
print(experiment)

with tempfile.TemporaryDirectory() as folder:
    comparison = asmc_pin.compare(experiment, out=Path(folder) / "quick")
    print(comparison)

rows = comparison.rows  # one for each controller, trial and joint; metrics in SI units
print(rows.groupby(["controller", "joint"], sort=False)[["rms_error", "torque_variation"]].median().head(6))
print(comparison.to_json_dict()["comparisons"][0])  # how sure the order of the first two is
