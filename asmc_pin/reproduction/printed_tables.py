"""What Baek, Jin and Han (2016) print: the tables, and the ranges that the figures show.

The paper's letters and units; DOI 10.1109/TIE.2016.2522386. No formula of a reference is printed, and of the figures
only the ranges of their axes are used here.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from asmc_pin.errors import ExperimentError
from asmc_pin.words.nearest_name import nearest

PPC, BSMC, EXISTING, PROPOSED = "PPC", "BSMC", "Existing", "Proposed"

TUNED_SUFFIX = " tuned"
"""At the end of the label of a scheme whose gains were tuned here; the paper has none."""


@dataclass(frozen=True)
class Printed:
    """One experiment of the paper.

    Attributes:
        name: Of the shipped experiment that runs it as printed; ``NAME_reconciled`` runs it as reconciled.
        title: What it is.
        table: Number of its table.
        window: The table is over the first so many seconds; None for the whole run.
        rms_deg: RMS tracking error of joints 1 and 2 by scheme, deg.
        figures: Number of the figure for each kind: motion, gains and s, torque, error.
        error_deg: Largest |e| that the error figure shows, by joint, deg.
        torque: Largest |τ| that the torque figure shows, N·m.
        gain: Largest k̂ that the figure of gains shows, by scheme.
        s: Largest |s| that it shows, by joint.
    """

    name: str
    title: str
    table: str
    window: float | None
    rms_deg: Mapping[str, tuple[float, float]]
    figures: Mapping[str, int]
    error_deg: tuple[float, float]
    torque: float
    gain: Mapping[str, float]
    s: tuple[float, float]


PAPER: Mapping[str, Printed] = {
    item.name: item
    for item in (
        Printed(
            name="baek2016_simulation_smooth",
            title="Section III, simulation, smooth reference",
            table="I",
            window=None,
            rms_deg={
                PPC: (1.60e-2, 11.55e-2),
                BSMC: (1.16e-2, 8.11e-2),
                EXISTING: (0.92e-2, 8.79e-2),
                PROPOSED: (0.50e-2, 4.89e-2),
            },
            figures={"motion": 3, "gains": 5, "torque": 6, "error": 7},
            error_deg=(0.04, 0.3),
            torque=90.0,
            gain={EXISTING: 600.0, PROPOSED: 600.0},
            s=(1.0, 0.4),
        ),
        Printed(
            name="baek2016_simulation_step",
            title="Section III, simulation, step-like reference",
            table="II",
            window=2.0,
            rms_deg={
                PPC: (14.70e-2, 7.09e-2),
                BSMC: (14.62e-2, 7.08e-2),
                EXISTING: (14.44e-2, 7.04e-2),
                PROPOSED: (9.53e-2, 5.44e-2),
            },
            figures={"motion": 4, "error": 8},
            error_deg=(0.9, 0.6),
            torque=90.0,
            gain={EXISTING: 600.0, PROPOSED: 600.0},
            s=(1.0, 0.4),
        ),
        Printed(
            name="baek2016_experiment",
            title="Section IV, experiment on two joints of an RV-4FD",
            table="III",
            window=None,
            rms_deg={PPC: (10.01e-2, 5.39e-2), EXISTING: (7.07e-2, 4.06e-2), PROPOSED: (4.32e-2, 3.57e-2)},
            figures={"motion": 10, "gains": 11, "torque": 12, "error": 13},
            error_deg=(0.4, 0.4),
            torque=75.0,
            gain={EXISTING: 8e3, PROPOSED: 6e3},
            s=(140.0, 140.0),
        ),
    )
}

NORM = (0.9869, 0.9886)
"""Range of ‖I − M⁻¹M̄‖₂ along the motion of the simulation."""

RECONCILED = "_reconciled"
NAMES = tuple(name + suffix for name in PAPER for suffix in ("", RECONCILED))
"""The shipped experiments of the paper, as printed and as reconciled."""


def known(names: Sequence[str] | None) -> list[str]:
    """The names asked for, each once; all when none is given.

    Raises:
        ExperimentError: one is unknown.
    """
    wanted = list(names or NAMES)
    for name in wanted:
        if name not in NAMES:
            raise ExperimentError("", f"'{name}' is no experiment of the paper; {nearest(name, NAMES)}")
    return list(dict.fromkeys(wanted))
