"""Between torque asked and torque applied: limits, lags, dead time, elastic joints. Parameters and running state.

Takes the law's torque; gives what acts on the arm. May import `parameters` and what is open to all.
"""
