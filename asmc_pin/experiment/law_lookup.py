"""From ``law = "…"`` to a class: one of the package's laws, or a user's own as ``my_module:MyLaw``."""

from __future__ import annotations

import importlib
import importlib.machinery
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType

from asmc_pin.baselines import BASELINES
from asmc_pin.controllers import CONTROLLERS
from asmc_pin.errors import ExperimentError
from asmc_pin.words.nearest_name import nearest

LAWS: dict[str, type] = {**CONTROLLERS, **BASELINES}
"""Every law of the package by its name: those that are blind to the arm, and those that know the model."""


def is_own(law: object) -> bool:
    """Whether ``law = "…"`` names code of the user's own, which runs as soon as it is imported."""
    return isinstance(law, str) and ":" in law


def load_law(law: str, folder: Path, key: str = "law") -> type:
    """The class of a control law.

    Args:
        law: A name from `LAWS`, or ``module:Class``. The module is looked for in the experiment's folder, then in the
            working directory, then wherever Python looks (``PYTHONPATH``).
        folder: Folder of the experiment.
        key: Path of the key in the experiment, for errors.

    Raises:
        ExperimentError: no such law, module or class, the module raises on import, or the class has no ``init`` or
            ``step``.
    """
    if ":" not in law:
        if law in LAWS:
            return LAWS[law]
        raise ExperimentError(
            key, f"there is no law '{law}': {nearest(law, LAWS)} (a law of your own is 'my_module:MyLaw')"
        )
    module_name, _, class_name = law.partition(":")
    if not all(part.isidentifier() for part in module_name.split(".")) or not class_name.isidentifier():
        raise ExperimentError(key, f"'{law}' is not of the form 'my_module:MyLaw'")
    module = _import(module_name, folder, key)
    found = getattr(module, class_name, None)
    if not isinstance(found, type):
        classes = [name for name, item in vars(module).items() if isinstance(item, type) and hasattr(item, "step")]
        hint = nearest(class_name, classes) if classes else "nor any other class with a method 'step'"
        raise ExperimentError(
            key, f"{getattr(module, '__file__', None) or module_name} has no class '{class_name}'; {hint}"
        )
    absent = [name for name in ("init", "step") if not callable(getattr(found, name, None))]
    if absent:
        raise ExperimentError(
            key, f"'{law}' is no control law: it has no method {' and no '.join(absent)}; see docs/controllers.md"
        )
    return found


def _import(name: str, folder: Path, key: str) -> ModuleType:
    with _search_first([str(folder.resolve()), str(Path.cwd())]):
        top = name.partition(".")[0]
        _forget_namesake(top)
        try:
            return importlib.import_module(name)
        except ModuleNotFoundError as error:
            if error.name is not None and name.startswith(error.name):
                if name.endswith(".py"):
                    raise ExperimentError(
                        key, f"'{name}' is a file; a law is named by its module, '{name.removesuffix('.py')}:MyLaw'"
                    ) from error
                places = " and ".join(dict.fromkeys(map(str, (folder.resolve(), Path.cwd()))))
                raise ExperimentError(
                    key,
                    f"there is no module '{error.name}'; looked for {top}.py in {places}, then in PYTHONPATH",
                ) from error
            raise ExperimentError(key, f"the module '{name}' cannot be imported: {error}") from error
        except (Exception, SystemExit) as error:  # a script that ends the process is no module either
            raise ExperimentError(
                key, f"the module '{name}' cannot be imported: {type(error).__name__}: {error}"
            ) from error


@contextmanager
def _search_first(folders: list[str]) -> Iterator[None]:
    saved = list(sys.path)
    sys.path[:0] = folders
    importlib.invalidate_caches()
    try:
        yield
    finally:
        sys.path[:] = saved


def _forget_namesake(top: str) -> None:
    """Drop a module of this name that was loaded from another folder: two experiments may each have a `my_law.py`."""
    loaded = sys.modules.get(top)
    if loaded is None or top in sys.builtin_module_names:
        return
    spec = importlib.machinery.PathFinder.find_spec(top)
    origin = getattr(loaded, "__file__", None)
    if spec is None or spec.origin is None or origin is None or Path(spec.origin).resolve() == Path(origin).resolve():
        return
    for name in [key for key in sys.modules if key == top or key.startswith(f"{top}.")]:
        del sys.modules[name]
