"""What acts on an arm from outside: disturbances, payloads that change, end stops, arms that differ from their URDF.

Takes time and state; gives torques and changed arms. May import `arms`, `parameters` and what is open to all.
"""
