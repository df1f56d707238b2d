"""What each law has to do exactly, or in which order, and how it is measured: through the plant itself.

docs/laws.md prints the table, tests/controllers/test_law_oracles.py holds every row. Two masses on one rail have a
constant, coupled inertia matrix; loads are constant within a period, and so is the reference's acceleration.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.arms import Arm, load_arm
from asmc_pin.controllers import (
    Adrc,
    Baek2016,
    Barrier,
    Dob,
    Implicit,
    Ism,
    Ivf,
    Ntsm,
    Pid,
    Plestan2010,
    Ppc,
    Sample,
    Setpoint,
    Sta,
)
from asmc_pin.engine import rollout
from asmc_pin.plant import Friction, Plant

PERIOD = 1e-3
GAINS = {"ks": 12.0, "beta": 9.0, "period": PERIOD}

# The rig ------------------------------------------------------------------------------------------------------------


@cache
def rail(*masses: float) -> Arm:
    """Masses on one rail, each carried by the one before it: M[i, j] is the sum of the masses from max(i, j) on."""
    links = "".join(
        f'<link name="m{i}"><inertial><mass value="{mass!r}"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" '
        f'izz="1"/></inertial></link><joint name="slide{i}" type="prismatic"><parent link="m{i - 1}"/>'
        f'<child link="m{i}"/><axis xyz="1 0 0"/><limit lower="-1000" upper="1000" effort="100000" velocity="10000"/>'
        "</joint>"
        for i, mass in enumerate(masses)
    )
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "rail.urdf"
        path.write_text(f'<robot name="rail"><link name="m-1"/>{links}</robot>')
        return load_arm(path)


@dataclass(frozen=True)
class Kicked:
    """A reference whose acceleration is another one in every period."""

    a: Array
    period: float = PERIOD
    duration: float = np.inf

    @property
    def nv(self) -> int:
        """Number of joints."""
        return int(self.a.shape[1])

    def evaluate(self, t: Array) -> Setpoint:
        """At the ticks, of which the times are multiples of the period."""
        a = self.a[: len(t)]
        v = np.concatenate([np.zeros((1, self.nv)), np.cumsum(self.period * a[:-1], axis=0)])
        moved = self.period * v[:-1] + 0.5 * self.period**2 * a[:-1]
        q = np.concatenate([np.zeros((1, self.nv)), np.cumsum(moved, axis=0)])
        return Setpoint(q, v, a)


@dataclass
class Watched:
    """A law under a load that only the plant feels, whose torques and states are kept."""

    law: Any
    load: Array
    told: list[Array] = field(default_factory=list)
    states: list[Any] = field(default_factory=list)

    @property
    def period(self) -> float:
        """L, s."""
        return float(self.law.period)

    def init(self, sample: Sample) -> Any:
        """The law's own."""
        return self.law.init(sample)

    def step(self, state: Any, sample: Sample, setpoint: Setpoint) -> tuple[Array, Any]:
        """The law's torque less the load, which the drive does not report."""
        k = len(self.told)
        felt = self.load[k - 1] if k else 0.0
        torque, state = self.law.step(state, Sample(sample.q, sample.v, sample.torque + felt), setpoint)
        self.told.append(torque[0])
        self.states.append(state)
        return torque - self.load[k], state


@dataclass(frozen=True)
class Trace:
    """One run; arrays of shape (T, nv), those over a period one tick shorter."""

    law: Any
    e: Array
    rate: Array
    wanted: Array
    torque: Array
    a: Array
    load: Array
    q: Array
    states: list[Any]

    @property
    def s(self) -> Array:
        """Sliding variable (4)."""
        return self.rate + self.law.ks * self.e

    @property
    def error(self) -> Array:
        """N_k of a law without a term of its own: the TDE error about what was wanted."""
        return np.asarray(self.a - self.wanted[:-1])

    @property
    def commanded(self) -> Array:
        """The acceleration that each tick's torque asks for, by time-delay estimation; from the second tick on.

        τ_k = M̄ (u_k − q̈̂_k) + τ_{k−1}, the estimate the mean over the last period: what the law did, not what its
        equations say that it does.
        """
        return np.asarray(np.diff(self.torque, axis=0) / self.law.mbar + self.a)

    @property
    def estimation_error(self) -> Array:
        """N_k about what was commanded, from the second tick on."""
        return np.asarray(self.a[1:] - self.commanded[:-1])


def run(
    law: Any,
    *masses: float,
    ticks: int = 300,
    load: Array | None = None,
    kicks: float = 5.0,
    seed: int = 0,
    start: tuple[float, float] | None = None,
    **plant: Any,
) -> Trace:
    """Run a law on masses on a rail along a kicked reference and under a load (T, nv), N; from rest, or from (q, v)."""
    rng = np.random.default_rng(seed)
    nv = len(masses)
    reference = Kicked(kicks * rng.standard_normal((ticks, nv)), law.period)
    loads = rng.standard_normal((ticks, nv)) if load is None else load
    watched = Watched(law, loads)
    moved = Plant(rail(*masses), friction=Friction(), **plant)
    begin = {} if start is None else {"q0": [start[0]] * nv, "v0": [start[1]] * nv}
    found = rollout(moved, watched, reference, (ticks - 1) * law.period, **begin)
    if found.status != ("ok",):
        raise RuntimeError(f"{type(law).__name__} diverged")
    q, v = found.q[0], found.v[0]
    e, rate = found.q_ref - q, found.v_ref - v
    wanted = found.a_ref + law.ks * rate + law.beta * (rate + law.ks * e)
    return Trace(
        law, e, rate, wanted, np.array(watched.told), np.diff(v, axis=0) / law.period, loads, q, watched.states
    )


def apart(one: Array, other: Array) -> float:
    """Largest difference, over the largest value of the second."""
    return float(np.abs(one - other).max() / np.abs(other).max())


# The oracles --------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Oracle:
    """A property of a law.

    Attributes:
        law: Its name in `CONTROLLERS`.
        property: What is looked at.
        must: What it has to be.
        measure: Runs it.
        within: How far the figure may be from `value`.
        value: What the figure has to be; 0 for an identity, whose figure is a relative error.
    """

    law: str
    property: str
    must: str
    measure: Callable[[], float]
    within: float
    value: float = 0.0

    def shown(self) -> str:
        """What was measured, for a table: the error of an identity rounded up to a power of ten, 1e-11 or more."""
        figure = self.measure()
        if self.within == 0.0 and figure == self.value:
            return "so, exactly"
        if self.value == 0.0:
            return f"error below {10.0 ** max(-11, int(np.ceil(np.log10(max(figure, 1e-300))))):.0e}"
        return f"{figure:.3g}"


ORACLES: list[Oracle] = []


def oracle(law: str, what: str, must: str, within: float = 1e-9, value: float = 0.0) -> Callable[[Any], Any]:
    """Enter a function as an oracle."""

    def register(measure: Callable[[], float]) -> Callable[[], float]:
        ORACLES.append(Oracle(law, what, must, cache(measure), within, value))
        return measure

    return register


def of_law(name: str) -> Iterator[Oracle]:
    """The oracles of one law."""
    return (item for item in ORACLES if item.law == name)


@oracle("ppc", "TDE error on one joint, a = m̄/m", "N_k = (1 − a)N_{k−1} + (1 − a)(u_{k−1} − u_k) − Δh/m")
def _ppc() -> float:
    return _recursion(Ppc(mbar=0.6, **GAINS), 1.0, 1.0)


@oracle("dob", "TDE error on one joint, a = m̄/m", "N_k = (1 − c a)N_{k−1} + (1 − a)(u_{k−1} − u_k) − Δh/m")
def _dob() -> float:
    law = Dob(mbar=2.6, cutoff_hz=60.0, **GAINS)
    return _recursion(law, 1.0, law.estimate_weight)


def _recursion(law: Any, mass: float, c: float) -> float:
    trace = run(law, mass)
    n, u, h = trace.error[:, 0], trace.wanted[:-1, 0], trace.load[:-1, 0]
    a = float(law.mbar) / mass
    expected = (1.0 - c * a) * n[:-1] - (1.0 - a) * np.diff(u) - np.diff(h) / mass
    return apart(n[1:], expected)


@oracle("dob", "`cutoff_hz = inf`", "the torque of `ppc`")
def _dob_is_ppc() -> float:
    gains = {"mbar": [0.7, 0.4], **GAINS}
    return apart(run(Dob(cutoff_hz=np.inf, **gains), 1.0, 0.8).torque, run(Ppc(**gains), 1.0, 0.8).torque)


@oracle("dob", "whether N falls at c·a = 1.98 and grows at 2.02, of a = 3", "1: yes, the edge is c·a = 2", 0.5, 1.0)
def _dob_edge() -> float:
    grown = []
    for edge in (1.98, 2.02):
        cutoff = -np.log(1.0 - edge / 3.0) / (2.0 * np.pi * PERIOD)
        law = Dob(mbar=3.0, cutoff_hz=cutoff, ks=0.1, beta=0.1, period=PERIOD)
        kick = np.zeros((120, 1))
        kick[2:] = 1.0
        n = np.abs(run(law, 1.0, ticks=120, load=kick, kicks=0.0).error[:, 0])
        grown.append(n[100] / n[40])
    return 1.0 if grown[0] < 1.0 < grown[1] else 0.0


@oracle("ivf", "`gain = 0`", "the torque of `ppc`")
def _ivf_is_ppc() -> float:
    gains = {"mbar": [0.7, 0.4], **GAINS}
    return apart(run(Ivf(gain=0.0, **gains), 1.0, 0.8).torque, run(Ppc(**gains), 1.0, 0.8).torque)


@oracle("ivf", "z, with N about what is wanted and G z", "z_{k+1} = (1 − LG) z_k − L N_k")
def _ivf() -> float:
    law = Ivf(mbar=[0.7, 0.4], gain=80.0, **GAINS)
    trace = run(law, 1.0, 0.8)
    z = np.array([state.ahead[0] for state in trace.states])
    n = trace.estimation_error
    return apart(z[2:], (1.0 - PERIOD * law.gain) * z[1:-1] - PERIOD * n)


@oracle("ivf", "z, as the integral of what was wanted less q̇", "z_k = z_{k−1} + L (u_{k−1} − q̈̂_k)")
def _ivf_integral() -> float:
    law = Ivf(mbar=[0.7, 0.4], gain=80.0, **GAINS)
    trace = run(law, 1.0, 0.8)
    z = np.array([state.ahead[0] for state in trace.states])
    return apart(z[1:], np.cumsum(PERIOD * (trace.wanted[:-1] - trace.a), axis=0))


@oracle("ivf", "steady error under a load that drifts at 5 N/s, over that of `ppc`", "0")
def _ivf_drift() -> float:
    ramp = 5.0 * PERIOD * np.arange(4000)[:, None]
    ends = [
        abs(run(law, 1.0, ticks=4000, load=ramp, kicks=0.0).e[-1, 0])
        for law in (Ivf(mbar=0.6, gain=40.0, **GAINS), Ppc(mbar=0.6, **GAINS))
    ]
    return ends[0] / ends[1]


@oracle("pid", "twin of TDC: M̄, K_s, β", "the motion of `ppc` whose ė, q̈, q̈_d are backward differences")
def _pid_twin() -> float:
    gains = {"mbar": [0.7, 0.4], **GAINS}
    twin = run(Pid(acceleration="position", **gains), 1.0, 0.8)
    return apart(twin.torque, run(_Differenced(Ppc(**gains)), 1.0, 0.8).torque)


@dataclass(frozen=True)
class _Differenced:
    """A law that gets backward differences of the angles, its own and the reference's, in the place of v and q̈_d."""

    law: Any

    def __getattr__(self, name: str) -> Any:
        return getattr(self.law, name)

    def init(self, sample: Sample) -> Any:
        return self.law.init(sample), None

    def step(self, state: Any, sample: Sample, setpoint: Setpoint) -> tuple[Array, Any]:
        inner, last = state
        length = self.law.period
        if last is None:
            v, rate, a = sample.v, setpoint.v, 0.0 * setpoint.a
        else:
            v, rate = (sample.q - last[0]) / length, (setpoint.q - last[1]) / length
            a = (rate - last[2]) / length
        torque, inner = self.law.step(inner, Sample(sample.q, v, sample.torque), Setpoint(setpoint.q, rate, a))
        return torque, (inner, (sample.q.copy(), setpoint.q.copy(), rate))


@oracle("pid", "K_p and K_d alone under a load h that stands", "e = h/K_p")
def _pid_droop() -> float:
    law = Pid(kp=400.0, ki=0.0, kd=40.0, period=PERIOD)
    e = run(law, 1.0, ticks=3000, load=np.full((3000, 1), 6.0), kicks=0.0).e
    return abs(float(e[-1, 0]) * 400.0 / 6.0 - 1.0)


@oracle("pid", "samples at the torque limit after e has changed its sign", "0", 0.0)
def _pid_windup() -> float:
    law = Pid(kp=400.0, ki=4000.0, kd=5.0, period=PERIOD)
    x = Sample(*(np.zeros((1, 1)) for _ in range(3)))
    state, late = law.init(x), 0
    for k in range(2000):
        target = np.full((1, 1), 1.0 if k < 1000 else -1e-3)
        torque, state = law.step(state, x, Setpoint(target, 0.0 * target, 0.0 * target))
        late += k >= 1000 and torque.item() >= 10.0
        x = Sample(x.q, x.v, np.clip(torque, -10.0, 10.0))
    return float(late)


@oracle("ism", "σ, from σ₀ = 0", "σ_{k+1} = σ_k − L (w_k + N_k)")
def _ism() -> float:
    law = Ism(mbar=[0.7, 0.4], gain=6.0, **GAINS)
    trace = run(law, 1.0, 0.8)
    after = np.array([state.surface[0] for state in trace.states])  # σ_k − L w_k
    w = trace.torque * 0.0
    sigma = np.zeros(after.shape[1])
    worst, largest = 0.0, 0.0
    for k in range(len(after) - 1):
        w[k] = np.where(sigma >= 0.0, law.gain, -law.gain)
        worst = max(worst, float(np.abs(after[k] - (sigma - PERIOD * w[k])).max()))
        largest = max(largest, float(np.abs(sigma).max()))
        sigma = sigma - PERIOD * (w[k] + (trace.a[k] - trace.wanted[k] - w[k]))
    return worst / largest


@oracle("implicit", "s inside the band, λ = 1", "s_{k+1} = −g N_k, g = L(1 + K_s L/2)")
def _implicit() -> float:
    return _implicit_error(1.0)


@oracle("implicit", "s inside the band, λ = 0.3", "s_{k+1} = (1 − λ) b_k − g N_k")
def _implicit_share() -> float:
    return _implicit_error(0.3)


def _implicit_error(share: float) -> float:
    law = Implicit(mbar=[0.7, 0.4], gain=1e6, share=share, **GAINS)
    trace = run(law, 1.0, 0.8)
    reach, ahead = _prediction(trace)
    return apart(trace.s[2:], (1.0 - share) * ahead[1:-1] - reach * trace.estimation_error)


def _prediction(trace: Trace) -> tuple[Array, Array]:
    """The reach g and the prediction b."""
    law = trace.law
    reach = PERIOD * (1.0 + 0.5 * law.ks * PERIOD)
    return reach, trace.s + PERIOD * law.ks * trace.rate - reach * (law.ks * trace.rate + law.beta * trace.s)


@oracle("implicit", "torque with ten times the K, inside the band", "the same to the last bit", 0.0)
def _implicit_gain() -> float:
    runs = [run(Implicit(mbar=0.6, gain=gain, share=1.0, **GAINS), 1.0).torque for gain in (1e3, 1e4)]
    return float(np.abs(runs[0] - runs[1]).max())


@oracle("plestan2010", '`switching = "implicit"`, s where λ|b| < k̂ g', "s_{k+1} = −g N_k")
def _plestan_implicit() -> float:
    law = Plestan2010(mbar=0.6, rate=1e5, epsilon=1e-4, floor=1.0, switching="implicit", **GAINS)
    return _adaptive_error(law)


@oracle("baek2016", '`switching = "implicit"`, s where λ|b| < k̂ g', "s_{k+1} = −g N_k")
def _baek_implicit() -> float:
    return _adaptive_error(Baek2016(mbar=0.6, phi=1e4, alpha=0.01, epsilon=1e-4, switching="implicit", **GAINS))


def _adaptive_error(law: Any) -> float:
    trace = run(law, 1.0)
    gain = np.array([state.gain[0] for state in trace.states])
    reach, ahead = _prediction(trace)
    inside = (np.abs(ahead) < gain * reach)[1:-1]
    if inside.sum() < 20:
        raise RuntimeError("hardly ever inside the band")
    return apart(trace.s[2:][inside], (-reach * trace.estimation_error)[inside])


@oracle("sta", "`k1 = k2 = 0`", "the torque of `ppc`, to the last bit", 0.0)
def _sta_is_ppc() -> float:
    gains = {"mbar": [0.7, 0.4], **GAINS}
    return float(np.abs(run(Sta(k1=0.0, k2=0.0, **gains), 1.0, 0.8).torque - run(Ppc(**gains), 1.0, 0.8).torque).max())


@oracle("sta", "mean of w under a load that drifts at 30 N/s, over −N", "1", 1e-3, 1.0)
def _sta_mean() -> float:
    ramp = 30.0 * PERIOD * np.arange(6000)[:, None]
    law = Sta(mbar=0.6, k1=2.0, k2=3.0, **GAINS)
    trace = run(law, 1.0, ticks=6000, load=ramp, kicks=0.0)
    w = (trace.commanded - trace.wanted[1:])[:-1]
    return float(-w[3000:].mean() / trace.estimation_error[3000:].mean())


@oracle("sta", "largest s in the limit cycle, over that at half the period", "4: it is of order L²", 0.4, 4.0)
def _sta_order() -> float:
    sizes = []
    for period in (PERIOD, 0.5 * PERIOD):
        ticks = round(3.0 / period)
        law = Sta(mbar=0.6, k1=4.0, k2=30.0, ks=12.0, beta=9.0, period=period)
        trace = run(law, 1.0, ticks=ticks, load=np.zeros((ticks, 1)) + 1.0, kicks=0.0)
        sizes.append(np.abs(trace.s[ticks // 2 :]).max())
    return float(sizes[0] / sizes[1])


@oracle("ntsm", "`exponent = 1`, `gain = 0`", "the torque of `ppc` with K_s = B")
def _ntsm_is_ppc() -> float:
    gains = {"mbar": [0.7, 0.4], **GAINS}
    law = Ntsm(exponent=1.0, stiffness=12.0, gain=0.0, boundary=1.0, **gains)
    return apart(run(law, 1.0, 0.8).torque, run(Ppc(**gains), 1.0, 0.8).torque)


@oracle("ntsm", "|e| left when e should be 0, at L over that at L/2", "2: of order L", 0.3, 2.0)
def _ntsm_time() -> float:
    p, b, e0 = 5.0 / 3.0, 6.0, 0.3
    reach = e0 ** (1.0 - 1.0 / p) / (b ** (1.0 / p) * (1.0 - 1.0 / p))
    left = []
    for period in (PERIOD, 0.5 * PERIOD):
        ticks = round(reach / period) + 1
        law = Ntsm(mbar=1.0, exponent=p, stiffness=b, gain=0.0, boundary=1.0, ks=12.0, beta=9.0, period=period)
        trace = run(law, 1.0, ticks=ticks, load=np.zeros((ticks, 1)), kicks=0.0, start=(-e0, (b * e0) ** (1.0 / p)))
        left.append(abs(trace.e[-1, 0]))
    return float(left[0] / left[1])


@oracle("barrier", "|s|/ε under a steady N of 5 rad/s², n = |N| − β|s|", "n/(1 + n)")
def _barrier() -> float:
    ramp = 5.0 * 0.6 * np.arange(3000)[:, None]
    law = Barrier(mbar=0.6, width=0.02, limit=60.0, **GAINS)
    trace = run(law, 1.0, ticks=3000, load=ramp, kicks=0.0)
    s = abs(float(trace.s[-1, 0]))
    n = 5.0 - law.beta * s
    return abs(s / law.width - n / (1.0 + n))


@oracle("barrier", "|s|/ε there", "0.83, inside", 0.01, 0.83)
def _barrier_inside() -> float:
    ramp = 5.0 * 0.6 * np.arange(3000)[:, None]
    trace = run(Barrier(mbar=0.6, width=0.02, limit=60.0, **GAINS), 1.0, ticks=3000, load=ramp, kicks=0.0)
    return abs(float(trace.s[-1, 0])) / 0.02


@oracle("adrc", "error of the observer under a load that stands, M̄ = M", "(z − z_o)³ of it is 0")
def _adrc() -> float:
    law = Adrc(mbar=1.3, observer_hz=60.0, **GAINS)
    trace = run(law, 1.3, load=np.full((300, 1), 7.0))
    third = np.array([state.load[0, 0] for state in trace.states]) + 7.0 / 1.3
    first = np.array([state.position[0, 0] for state in trace.states]) - trace.q[:, 0]
    pole = law.observer_pole
    worst = 0.0
    for x in (first, third):
        left = x[3:] - 3.0 * pole * x[2:-1] + 3.0 * pole**2 * x[1:-2] - pole**3 * x[:-3]
        worst = max(worst, float(np.abs(left).max() / np.abs(x).max()))
    return worst


@oracle("adrc", "`observer_hz = inf`: ẑ₃, M̄ = M", "the mean of the last two loads", 1e-7)
def _adrc_deadbeat() -> float:
    trace = run(Adrc(mbar=1.3, observer_hz=np.inf, **GAINS), 1.3)
    third = np.array([state.load[0] for state in trace.states])
    loads = -trace.load / 1.3
    return apart(third[3:], 0.5 * (loads[2:-1] + loads[1:-2]))
