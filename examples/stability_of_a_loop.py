"""Is the sampled loop stable over the workspace, and how far may gains, period and delay move?"""

import asmc_pin

arm = asmc_pin.load_arm("two_link")
mbar = asmc_pin.design(arm, explain=False).mbar

for gain in (10.0, 1000.0):
    report = asmc_pin.stability(arm, mbar, ks=gain, beta=gain, period=0.001, samples=256)
    print(f"with β = k_s = {gain:g} 1/s:\n{report}\n")
    assert report.stable == (gain < 100.0)
