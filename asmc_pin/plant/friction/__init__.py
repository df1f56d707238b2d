"""Joint friction: parameters, and compiled laws with sticking solved exactly within a step.

Takes velocities and driving torques; gives the friction torque. May import `parameters` and what is open to all.
"""
