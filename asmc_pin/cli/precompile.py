"""Compile the kernels that every run needs, once, into numba's cache: ``python -m asmc_pin.cli.precompile``.

Set-up does it, so that the first demo is as quick as the second. Without it they compile on first use.
"""

from __future__ import annotations


def precompile() -> None:
    """Run each compiled path on a small case."""
    import asmc_pin
    from asmc_pin.condition.certificate import certify
    from asmc_pin.controllers import Ppc
    from asmc_pin.plant import Friction, Plant
    from asmc_pin.references import Ramps

    arm = asmc_pin.load_arm("two_link")
    asmc_pin.verify(arm, 0.01, samples=64, starts=2)
    certify(arm, 0.01, gap=0.5, levels=False)
    law = Ppc(mbar=0.01, ks=1.0, beta=1.0, period=0.001)
    reference = Ramps(points=[[0.0, 0.0], [0.1, 0.1]], times=[0.0, 0.01])
    asmc_pin.rollout(Plant(arm, friction=Friction(1.0, 0.1)), law, reference, 0.01)


if __name__ == "__main__":
    precompile()
