"""The plant: its parameters, and how its trials begin."""

from __future__ import annotations

from collections.abc import Sequence

from asmc_pin._typing import Array
from asmc_pin.plant.plant_parameters import PlantParameters
from asmc_pin.plant.plant_state import Motion


class Plant(PlantParameters):
    """Ground truth: arms with friction and drives, for one trial or a batch; parameters only, `begin` starts it.

    What is None or empty is ideal or absent: drives apply their command at once, sensors report the truth.

    Attributes:
        arms: The arm of all trials, or one per trial (payload, armature and the like may differ, the joints may not).
            Rotors of rigid gears are in the armature.
        substeps: Integration steps per control period; the torque is held over all of them.
        friction: Joint friction; its arrays may be per trial.
        effort_limit: Torque limits of the drives, (nv,) or (batch, nv), N·m (N); inf for none.
        start: ``"holding"``: before t = 0 the drives balance gravity at q(0), as far as their limits go, as when a
            brake opens; ``"relaxed"``: they apply nothing.
        integrator: Name of the scheme in `asmc_pin.plant.INTEGRATORS`.
        speed_bound: A trial has diverged when a joint is faster, rad/s (m/s).
        error_bound: A trial has diverged when a joint is further from its reference, rad (m).
        threads: Threads for Pinocchio; the result does not depend on them.
        drive: What comes between command and joint torque.
        sensor: What the law is told of angles and velocities.
        end_stops: Stops at the position limits.
        disturbances: External torques and wrenches.
        payload_changes: What is picked up or put down, in order of time.
        spread: Scatter of the parameters from trial to trial.
        seed: Seed of all that is random.
        engine: What computes a rollout: ``"compiled"``, this package's own recursion, which every arm is held against
            Pinocchio for; ``"pinocchio"``, Pinocchio itself, several times slower. docs/plant.md says what else is run
            by Pinocchio.
        first_trial: Number of the study's trial that is trial 0 here, so that one of many can be run again alone.
    """

    def begin(self, q: Array, v: Array, period: float, trials: Sequence[int] | None = None) -> Motion:
        """Trials at rest in time, ready for their first control tick.

        Args:
            q: q(0), shape (batch, nv), rad.
            v: v(0), shape (batch, nv), rad/s.
            period: Control period, s.
            trials: Numbers of the trials, which seed what is random in them; 0, 1, … when omitted.

        Raises:
            ParameterError: the plant's arms, friction or limits are for another number of trials.
        """
        numbers = range(len(q)) if trials is None else trials
        return Motion(self.for_trials(numbers), period, q, v, numbers)
