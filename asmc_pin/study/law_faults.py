"""What a law of somebody's own does wrong while it runs, told as a mistake of the experiment that names it."""

from __future__ import annotations

import traceback
from collections.abc import Iterator
from contextlib import contextmanager

from asmc_pin.errors import AsmcPinError, ExperimentError
from asmc_pin.experiment import Experiment
from asmc_pin.experiment.law_lookup import is_own


@contextmanager
def told_of_its_law(experiment: Experiment, label: str) -> Iterator[None]:
    """In the block, what a controller's run raises becomes an `ExperimentError` that names the controller.

    A fault in one of the package's own laws stays what it is: a fault of ours.
    """
    try:
        yield
    except AsmcPinError as error:
        raise ExperimentError(f"controllers.{label}", str(error)) from error
    except (Exception, SystemExit) as error:
        name = experiment.controllers[label]["law"]
        if not is_own(name):
            raise
        where = traceback.extract_tb(error.__traceback__)[-1]
        raise ExperimentError(
            f"controllers.{label}",
            f"the law '{name}' raised {type(error).__name__}: {error} ({where.filename}, line {where.lineno})",
        ) from error
