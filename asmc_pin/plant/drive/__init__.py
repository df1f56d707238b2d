"""Between torque asked and torque applied: limits, lags, dead time, elastic joints. Parameters and running state.

In comes the law's torque, out goes what acts on the arm. May import `parameters` and what is open to all.
"""
