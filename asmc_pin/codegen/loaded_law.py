"""An exported law back in Python: its C, compiled and called tick by tick, in a loop that is not ours."""

from __future__ import annotations

import ctypes
import re
import tempfile
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from asmc_pin._typing import Array
from asmc_pin.codegen.c_compiler import CompilerError, compile_c, find_compiler
from asmc_pin.codegen.exported_code import ABI
from asmc_pin.controllers.protocol import Sample, Setpoint
from asmc_pin.disk.reading import user_path
from asmc_pin.errors import ParameterError, ResultError

STATUSES = ("ok", "limited", "bad time", "bad input", "bad result", "fault")
"""What a tick comes to, by the number of the exported status."""


class LoadedState(NamedTuple):
    """State of a batch: of each trial the bytes of its structure in C.

    Attributes:
        bytes: One a trial.
        status: What the last tick came to, one a trial.
    """

    bytes: tuple[bytes, ...]
    status: tuple[str, ...]


class LoadedLaw:
    """The C of an export as a callable of one arm, and as a controller of a batch.

    ``law(q, v, tau, q_ref, v_ref, a_ref)`` gives the torque to hold until the next call, (nv,), N·m. The first call is
    preceded by `restart` with its sample. As a controller (`init`, `step`) it runs in `asmc_pin.rollout`.

    Attributes:
        name: Of its files, and the prefix of its names in C.
        nv: Number of joints.
        period: L, s.
        real: ``"double"`` or ``"float"``.
        status: What the last tick came to, see `STATUSES`.
    """

    def __init__(self, name: str, library: ctypes.CDLL, period: float) -> None:
        self.name, self._library = name, library
        self.nv = int(self._function("joints", ctypes.c_uint32)())
        size = int(self._function("bytes_of_real", ctypes.c_size_t)())
        self.real = {4: "float", 8: "double"}[size]
        self.period = period
        self.status = "ok"
        self._number: Any = np.float32 if size == 4 else np.float64
        self._bytes = int(self._function("bytes_of_state", ctypes.c_size_t)())
        self._parameters = self._function("parameters_exported", ctypes.c_void_p)()
        self._init = self._function("init", ctypes.c_int)
        self._step = self._function("step", ctypes.c_int)
        self._state: Any = None
        self._dt = ctypes.c_float if size == 4 else ctypes.c_double

    def restart(self, q: ArrayLike, v: ArrayLike, tau: ArrayLike) -> None:
        """The state before the first tick, from the sample of t = 0."""
        self._state = ctypes.create_string_buffer(self._bytes)
        told = self._told(q, v, tau)
        self.status = STATUSES[self._init(ctypes.c_void_p(self._parameters), self._state, told.ctypes.data_as(_ANY))]

    def __call__(
        self,
        q: ArrayLike,
        v: ArrayLike,
        tau: ArrayLike,
        q_ref: ArrayLike,
        v_ref: ArrayLike,
        a_ref: ArrayLike,
        dt: float | None = None,
    ) -> Array:
        """A tick.

        Args:
            q: Angles, (nv,), rad.
            v: Velocities, rad/s.
            tau: Torque that the drives applied since the last tick, N·m.
            q_ref: Set point, rad.
            v_ref: Its velocity, rad/s.
            a_ref: Its acceleration, rad/s².
            dt: Time since the last tick, s; L when omitted.

        Returns:
            The torque to hold until the next, (nv,), N·m.
        """
        if self._state is None:
            self.restart(q, v, tau)
        told, wanted = self._told(q, v, tau), self._told(q_ref, v_ref, a_ref)
        torque = np.empty(self.nv, dtype=self._number)
        self.status = STATUSES[
            self._step(
                ctypes.c_void_p(self._parameters),
                self._state,
                told.ctypes.data_as(_ANY),
                wanted.ctypes.data_as(_ANY),
                self._dt(self.period if dt is None else dt),
                torque.ctypes.data_as(_ANY),
            )
        ]
        return torque.astype(np.float64)

    def init(self, sample: Sample) -> LoadedState:
        """State of a batch before its first tick; see `asmc_pin.Controller`."""
        made, told = [], []
        for trial in range(len(sample.q)):
            self.restart(sample.q[trial], sample.v[trial], sample.torque[trial])
            made.append(self._state.raw)
            told.append(self.status)
        self._state = None
        return LoadedState(tuple(made), tuple(told))

    def step(self, state: LoadedState, sample: Sample, setpoint: Setpoint) -> tuple[Array, LoadedState]:
        """Torque to hold over the next period, (batch, nv), N·m, and the next state."""
        shape = sample.q.shape
        wanted = [np.broadcast_to(x, shape) for x in (setpoint.q, setpoint.v, setpoint.a)]
        torque, made, told = np.empty(shape), [], []
        for trial in range(shape[0]):
            self._state = ctypes.create_string_buffer(state.bytes[trial], self._bytes)
            seen = (sample.q[trial], sample.v[trial], sample.torque[trial])
            torque[trial] = self(*seen, *(x[trial] for x in wanted))
            made.append(self._state.raw)
            told.append(self.status)
        self._state = None
        return torque, LoadedState(tuple(made), tuple(told))

    def _told(self, *rows: ArrayLike) -> Array:
        try:
            return np.array([np.asarray(row, dtype=self._number).reshape(self.nv) for row in rows])
        except ValueError:
            raise ParameterError("sample", f"expected {self.nv} numbers for each of its fields") from None

    def _function(self, name: str, gives: Any) -> Any:
        function = getattr(self._library, f"{self.name}_{name}")
        function.restype = gives
        return function


_ANY = ctypes.c_void_p


def load_exported(folder: str | Path) -> LoadedLaw:
    """Compile what `export` wrote and load it.

    Args:
        folder: That of the export.

    Raises:
        ResultError: there is no export in it, or one of another ABI.
        CompilerError: there is no C compiler, or it fails.
    """
    path = user_path(folder)
    runners = sorted(path.glob("*_runner.c"))
    if len(runners) != 1:
        raise ResultError(path, f"{path} holds no export; give the folder of `asmc-pin export --out`")
    name = runners[0].name.removesuffix("_runner.c")
    header = (path / f"{name}.h").read_text(encoding="utf-8")
    found = re.search(rf"^#define {name.upper()}_PERIOD (\S+?)f?$", header, re.M)
    abi = re.search(rf"^#define {name.upper()}_ABI (\d+)$", header, re.M)
    if found is None or abi is None or int(abi[1]) != ABI:
        raise ResultError(path, f"{path} is not of ABI {ABI}; export it anew")
    compiler = find_compiler()
    if compiler is None:
        raise CompilerError("there is no C compiler here; install gcc or clang, or set CC")
    with tempfile.TemporaryDirectory(prefix="asmc-pin-") as made:
        library = Path(made) / f"{name}.so"
        compile_c(compiler, [path / f"{name}.c"], library, "-shared", "-fPIC")
        loaded = ctypes.CDLL(str(library))  # stays loaded after the file is gone
    return LoadedLaw(name, loaded, float(found[1]))
