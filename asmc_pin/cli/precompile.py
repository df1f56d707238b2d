"""Compile the kernels that every run needs, once, into numba's cache: ``python -m asmc_pin.cli.precompile``.

Set-up does it, so that the first demo is as quick as the second. Without it they compile on first use.
"""

from __future__ import annotations


def precompile() -> None:
    """Run each compiled path on a small case."""
    import numpy as np

    import asmc_pin
    from asmc_pin.condition.certificate import certify
    from asmc_pin.controllers import CONTROLLERS, Ppc, Sample, Setpoint
    from asmc_pin.plant import Friction, Plant
    from asmc_pin.references import Ramps

    arm = asmc_pin.load_arm("two_link")
    asmc_pin.verify(arm, 0.01, samples=64, starts=2)
    certify(arm, 0.01, gap=0.5, levels=False)
    law = Ppc(mbar=0.01, ks=1.0, beta=1.0, period=0.001)
    reference = Ramps(points=[[0.0, 0.0], [0.1, 0.1]], times=[0.0, 0.01])
    for engine in ("compiled", "pinocchio"):
        asmc_pin.rollout(Plant(arm, friction=Friction(1.0, 0.1), engine=engine), law, reference, 0.01)
    law.step(law.init(sample := Sample(*np.zeros((3, 1, 2)))), sample, Setpoint(*np.zeros((3, 1, 2))))
    for each in CONTROLLERS.values():
        if each.trial_step is not None:
            each.trial_step.address  # noqa: B018 - asked for, it is compiled


if __name__ == "__main__":
    precompile()
