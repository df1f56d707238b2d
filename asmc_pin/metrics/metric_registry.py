"""What a metric is, what it is told, and the registry of all of them.

A metric is a function of a `Rollout` and the `MetricSettings`; it returns one number per trial and joint. It enters the
registry by ``@metric(...)`` above it: tables, results and `docs/metrics.md` pick it up from `METRICS`.

Conventions: e = q_d − q (as in Baek 2016); T samples at t_k = k·L, k = 0 … T−1; torque τ_k is held over [t_k, t_{k+1}),
so the run holds τ_0 … τ_{T−2}, and those are what the torque metrics see. A trial that diverged has no metric: every
figure of it is NaN (null in JSON, a dash in tables) and its status says when it happened, because a number over the
part that ran would depend on how early the trial broke down, and would flatter the law that broke down first. The one
exception is when a robot would have tripped, which is told before the end.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TYPE_CHECKING, Literal

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.errors import ParameterError

if TYPE_CHECKING:
    from asmc_pin.engine import Rollout

# Of a revolute and of a prismatic joint, SI.
QUANTITIES: Mapping[str, tuple[str, str]] = MappingProxyType(
    {
        "position": ("rad", "m"),
        "integral of position": ("rad·s", "m·s"),
        "integral of squared position": ("rad²·s", "m²·s"),
        "integral of position and time": ("rad·s²", "m·s²"),
        "torque": ("N·m", "N"),
        "torque rate": ("N·m/s", "N/s"),
        "integral of squared torque": ("N²·m²·s", "N²·s"),
        "energy": ("J", "J"),
        "gain": ("rad/s²", "m/s²"),
        "rate": ("1/s", "1/s"),
        "time": ("s", "s"),
        "share": ("1", "1"),
        "count": ("ticks", "ticks"),
    }
)


LEAST = 1e-6
"""What is too small to matter, SI: of an error a microradian or a micrometre, less than anyone could set or measure."""

MOVED = "moved_"
"""How the columns of a summary begin that say how half the step moves a metric, relative to the finer figure."""


@dataclass(frozen=True, slots=True)
class TripLimits:
    """What stops a robot, each a scalar or nv values; infinite where nothing is known, and then not judged.

    Attributes:
        torque: Largest torque, N·m.
        torque_rate: Largest change of the torque from tick to tick over the period, N·m/s.
        velocity: Largest speed at a tick, rad/s.
    """

    torque: float | Array = np.inf
    torque_rate: float | Array = np.inf
    velocity: float | Array = np.inf

    @property
    def judged(self) -> bool:
        """Whether there is any limit."""
        return bool(any(np.isfinite(x).any() for x in (self.torque, self.torque_rate, self.velocity)))


@dataclass(frozen=True, slots=True)
class MetricSettings:
    """What the metrics need in addition to the run.

    Attributes:
        cutoff_hz: Frequency above which torque power counts as high, Hz.
        settling_band: Band of |e| in which a joint counts as settled, a scalar or nv values, rad (m if prismatic).
        effort_limit: Torque limits, a scalar or nv values, N·m; infinite where there is none.
        torque_rate_limit: How fast a robot lets its torque command change, a scalar or nv values, N·m/s.
        trips: What stops the robot that the experiment names.
    """

    cutoff_hz: float = 50.0
    settling_band: float | Array = 0.002
    effort_limit: float | Array = field(default=np.inf)
    torque_rate_limit: float | Array = 1000.0
    trips: TripLimits = field(default_factory=TripLimits)

    def __post_init__(self) -> None:
        for name in ("cutoff_hz", "settling_band", "effort_limit", "torque_rate_limit"):
            if not np.all(np.asarray(getattr(self, name)) > 0.0):
                raise ParameterError(name, f"must be positive, got {getattr(self, name)}")


_Function = Callable[["Rollout", MetricSettings], Array]

Best = Literal["smallest", "largest"] | None
"""Which figure of several is the best; None where neither is, as of a torque or a gain."""


@dataclass(frozen=True)
class Metric:
    """One number per trial and joint that says how well a controller did.

    Attributes:
        name: Key in results and in ``compare --json``.
        title: What a table calls it.
        quantity: Key of `QUANTITIES`, which gives the unit.
        formula: The definition, in plain text.
        source: Where the definition comes from.
        best: Which figure of several is the best; tables mark it.
        main: Whether a person reads it first; the other metrics follow.
        function: Computes it for every trial as if none had diverged, shape (batch, nv).
        of_diverged: Whether a trial that diverged has it too: what happened before is known by then.
    """

    name: str
    title: str
    quantity: str
    formula: str
    source: str
    best: Best
    main: bool
    function: _Function
    of_diverged: bool = False

    @property
    def unit(self) -> str:
        """SI unit, that of a prismatic joint after it where it differs; ``"1"`` for a pure number."""
        revolute, prismatic = QUANTITIES[self.quantity]
        return revolute if revolute == prismatic else f"{revolute} or {prismatic}"

    @property
    def least(self) -> float:
        """What a smaller figure counts as in a geometric mean over joints: `LEAST`, and LEAST² of what is squared."""
        return LEAST**2 if "squared" in self.quantity else LEAST

    def __call__(self, rollout: Rollout, settings: MetricSettings | None = None) -> Array:
        """Evaluate on a rollout.

        Args:
            rollout: What the plant did.
            settings: Cut-off, settling band, limits of torque and of its rate; the defaults where omitted.

        Returns:
            Shape (batch, nv), SI; NaN where the metric is not defined, which most are not of a trial that diverged.

        Raises:
            ParameterError: not every tick of the run is logged.
        """
        rollout.need_every_tick("metrics are")
        with np.errstate(invalid="ignore"):  # NaN after a divergence is expected, and masked below.
            values = np.array(self.function(rollout, settings or MetricSettings()), dtype=np.float64)
        if not self.of_diverged:
            values[np.asarray(rollout.status) != "ok"] = np.nan
        return values


_REGISTRY: dict[str, Metric] = {}
METRICS: Mapping[str, Metric] = MappingProxyType(_REGISTRY)


def metric(
    title: str,
    quantity: str,
    formula: str,
    source: str,
    *,
    best: Best = None,
    main: bool = False,
    of_diverged: bool = False,
) -> Callable[[_Function], _Function]:
    """Make a function one of the metrics, under its own name; see `Metric` for the arguments."""

    def register(function: _Function) -> _Function:
        name = function.__name__
        _REGISTRY[name] = Metric(name, title, quantity, formula, source, best, main, function, of_diverged)
        return function

    return register


def evaluate(rollout: Rollout, settings: MetricSettings | None = None) -> dict[str, Array]:
    """All metrics of a rollout: name -> array of shape (batch, nv), in SI units."""
    return {name: metric(rollout, settings) for name, metric in METRICS.items()}


ROUNDING = 1e-9
"""Part of a limit by which a figure may be beyond it: one that is as large as the limit is within, however rounded."""

OURS = "this toolkit"
BAEK = "Baek, Jin, Han 2016, Tables I to III"


def tracking_error(rollout: Rollout) -> Array:
    """The error e = q_d − q, shape (batch, T, nv)."""
    return rollout.q_ref - rollout.q


def held_torque(rollout: Rollout) -> Array:
    """The torques that are held within the run, shape (batch, T − 1, nv)."""
    return rollout.torque[:, :-1]


def torque_steps(rollout: Rollout) -> Array:
    """How far the held torque goes from a tick to the next, shape (batch, T − 2, nv)."""
    return np.asarray(np.abs(np.diff(held_torque(rollout), axis=1)))


def run_length(rollout: Rollout) -> float:
    """From the first sample to the last, s."""
    return float(rollout.time[-1] - rollout.time[0])
