"""A comparison that takes a fraction of a second; its second law diverges, as its gains are far too high."""

SHORT = """
name = "short"
arm = "two_link"
period = 0.001
duration = 0.2
[ensemble]
trials = 1
[plant]
friction = { coulomb = 1.0, viscous = 0.1 }
[reference]
kind = "multisine"
offset = [0.3, 0.2]
amplitude = [[0.2], [0.2]]
frequency = [[0.5], [0.5]]
[defaults]
mbar = 0.01
ks = 5.0
beta = 5.0
[controllers.PPC]
law = "ppc"
[controllers.Wild]
law = "ppc"
beta = 900.0
ks = 900.0
"""
