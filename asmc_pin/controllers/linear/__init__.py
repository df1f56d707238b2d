"""Laws without a switching term: linear in what the drives report, whatever the motion.

Takes samples and set points; gives torque. May import what `controllers` may; `asmc_pin.controllers` lists the laws.
"""
