"""Joint friction: parameters, and compiled laws with sticking solved exactly within a step.

In come velocities and driving torques, out goes the friction torque. May import `parameters` and what is open to all.
"""
