"""The parts of `rollout.py`: what is run, what other engines take, and how the cost grows."""
