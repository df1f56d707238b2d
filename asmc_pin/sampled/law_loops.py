"""The sampled loops that the laws of an experiment make, laws with the same loop together."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from asmc_pin._typing import Array
from asmc_pin.controllers import TdeLaw
from asmc_pin.controllers.linear_form import linear_form, linear_throughout
from asmc_pin.controllers.ppc import Ppc
from asmc_pin.sampled.loop_analysis import loop_for
from asmc_pin.sampled.noise.sensor_model import LoopSensor
from asmc_pin.sampled.sampled_loop import SampledLoop

if TYPE_CHECKING:
    from asmc_pin.arms import Arm


@dataclass(frozen=True, eq=False)
class LawLoop:
    """The loop of PPC (7) that one or more laws contain.

    Attributes:
        labels: The laws that share it.
        loop: Gains and timing.
        layers: By label, what β is raised by inside a boundary layer, 1/s, where the law has one.
        bands: By label, the loop inside a band in which the law is linear, but not so much more β.
    """

    labels: list[str]
    loop: SampledLoop
    layers: dict[str, Array]
    bands: dict[str, SampledLoop]

    @property
    def title(self) -> str:
        """The labels in a row."""
        return ", ".join(self.labels)


def law_loops(
    arm: Arm,
    controllers: Mapping[str, Any],
    period: float | None = None,
    *,
    delay: float = 0.0,
    sensor: LoopSensor | None = None,
) -> list[LawLoop]:
    """The loops of laws.

    Args:
        arm: The arm.
        controllers: Label -> law. One without `mbar, ks, beta` is not of this kind and is passed over.
        period: Control period, s; by default each law's own.
        delay: The plant's transport delay, periods.
        sensor: Its sensors; ideal ones by default.

    Raises:
        ParameterError: a law is for another number of joints.
    """
    found: dict[tuple[Any, ...], LawLoop] = {}
    for label, law in controllers.items():
        if any(getattr(law, name, None) is None for name in ("mbar", "ks", "beta")):
            continue
        timing = {
            "acceleration": getattr(law, "acceleration", "velocity"),
            "filter_hz": getattr(law, "filter_hz", None),
            "pairing": "mean" if getattr(law, "averages_torque", False) else "last",
            "delay": delay,
            **({} if sensor is None else sensor.timing),
        }
        slope = getattr(law, "boundary_slope", None)
        near = None if slope is not None or not _own_loop(law, arm.nv) else law
        alone = near if near is not None and linear_throughout(law, arm.nv) else None
        length = law.period if period is None else period
        loop = loop_for(arm, law.mbar, law.ks, law.beta, length, law=alone, **timing)
        key = (loop.mbar.tobytes(), loop.ks.tobytes(), loop.beta.tobytes(), loop.period, id(alone), *timing.values())
        shared = found.setdefault(key, LawLoop([], loop, {}, {}))
        shared.labels.append(label)
        if slope is not None:
            shared.layers[label] = slope
        elif near is not None and alone is None:
            shared.bands[label] = replace(loop, law=near)
    return list(found.values())


def _own_loop(law: Any, nv: int) -> bool:
    """Whether a law of the package is linear near its set point, and not PPC alone."""
    return isinstance(law, TdeLaw) and not isinstance(law, Ppc) and linear_form(law, nv) is not None
