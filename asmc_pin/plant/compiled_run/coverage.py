"""Which plants compiled code runs."""

from __future__ import annotations

from asmc_pin.plant import integrators
from asmc_pin.plant.compiled_run.held_dynamics import no_recursion
from asmc_pin.plant.compiled_run.run_rows import SCHEMES
from asmc_pin.plant.plant_parameters import PlantParameters


def not_compiled(plant: PlantParameters) -> str | None:
    """What of a plant compiled code does not have, in words; None if it has all of it."""
    reason = next(filter(None, map(no_recursion, dict.fromkeys(plant.arms))), None)
    if reason is not None:
        return reason
    if plant.drive is not None and plant.drive.elastic:
        return "elastic joints"
    if plant.friction.terms:
        return "friction terms written in Python"
    if any(disturbance.link is not None for disturbance in plant.disturbances):
        return "wrenches at links"
    shipped = getattr(integrators, plant.integrator, None)
    if plant.integrator not in SCHEMES or integrators.INTEGRATORS[plant.integrator] is not shipped:
        return "an integrator of one's own"
    return None
