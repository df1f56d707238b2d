"""Laws without a switching term: linear in what the drives report, whatever the motion.

In come samples and set points, out goes torque. May import what `controllers` may; `asmc_pin.controllers` lists the
laws.
"""
