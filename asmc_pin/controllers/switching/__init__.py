"""Laws that add a switching term to PPC, or something that saturates like one.

Takes samples and set points; gives torque. May import what `controllers` may; `asmc_pin.controllers` lists the laws.
"""
