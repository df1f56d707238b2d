"""The best M̄ for an arm, why it is no better, and gains for a loop of 1 kHz that keep stated margins."""

import asmc_pin

arm = asmc_pin.load_arm("two_link", payload=1.0)

found = asmc_pin.design(arm)
print(found)

gains = asmc_pin.suggest_gains(arm, found.mbar, period=0.001, gain_margin=2.0, delay_margin=1.0)
print(gains)
print(f"β = {gains.loop.beta[0]:.4g} 1/s, k_s = {gains.loop.ks[0]:.4g} 1/s with M̄ = {gains.mbar}")
