"""What a comparison was run on and where it comes from: the arm, the experiment, hashes and files."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from asmc_pin.arms import Arm
from asmc_pin.condition.hypotheses import Premises
from asmc_pin.condition.premises import premises_along
from asmc_pin.pages.html_fragments import definition_list, scroll, table_html
from asmc_pin.pages.tables.findings_page import experiment_details
from asmc_pin.pages.tables.text_table import Table, number
from asmc_pin.results.kept_ticks import reference_range
from asmc_pin.results.result_folder import Result


def arm_and_experiment(result: Result) -> Iterator[str]:
    """The arm's joints, what is supposed, and the experiment as run."""
    about, arm = simulated_arm(result)
    yield '<h2 id="conditions">Arm and experiment</h2>'
    yield scroll("Joints of the arm", table_html(_joint_table(arm), {}))
    yield definition_list(about.rows())
    yield experiment_details("The experiment as run", result.experiment.to_toml())


def simulated_arm(result: Result) -> tuple[Premises, Arm]:
    """The simulated arm, with the rotors of its drives, and what is supposed about it."""
    arm = result.experiment.build_plant().arm
    return premises_along(arm, reference_range(result.dataset)), arm


def _joint_table(arm: Arm) -> Table:
    rows = []
    for i, name in enumerate(arm.joint_names):
        turns = arm.joint_kinds[i] == "revolute"
        factor, unit = (180.0 / np.pi, "deg") if turns else (1e3, "mm")
        low, high = factor * arm.lower[i], factor * arm.upper[i]
        reach = f"{number(low)} … {number(high)} {unit}" if np.isfinite(low) and np.isfinite(high) else "not declared"
        effort = arm.effort_limit[i]
        force = f"{number(float(effort))} {'N·m' if turns else 'N'}" if np.isfinite(effort) else "not declared"
        rows.append([name, arm.joint_kinds[i], reach, force, f"{number(float(arm.armature[i]))}"])
    return Table("Joints", ["joint", "kind", "range", "effort limit", "reflected inertia [kg·m² or kg]"], rows)


def origin(result: Result) -> Iterator[str]:
    """Hashes, provisos, seed and files."""
    arm = result.experiment.build_arm()
    yield '<h2 id="provenance">Where this comes from</h2>'
    yield definition_list(
        [
            ("URDF", arm.source.name),
            ("SHA-256 of the URDF", str(result.provenance.get("arm", {}).get("sha256", arm.sha256))),
            *((proviso.kind[:1].upper() + proviso.kind[1:], proviso.text) for proviso in arm.provisos),
            ("Seed", str(result.experiment.seed)),
            ("Trajectories", "trajectories.nc"),
            ("Summary", "summary.parquet, summary.md, summary.tex"),
        ]
    )
    yield (
        "<footer>Made by asmc_pin. Versions of the software and times stand in provenance.json beside this page; "
        "all else is bitwise repeatable on the same machine.</footer>"
    )
