"""Laws that add a switching term to PPC, or something that saturates like one.

In come samples and set points, out goes torque. May import what `controllers` may; `asmc_pin.controllers` lists the
laws.
"""
