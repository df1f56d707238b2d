"""The data flow of the package goes one way: what each part may import, read from the source.

A new part of the package needs a row in MAY_IMPORT, which says where in the flow it stands.
"""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from collections import Counter
from pathlib import Path

import pytest
from import_graph import (
    OPEN,
    circles,
    docstring,
    file_graph,
    folders,
    imports,
    imports_of,
    layers,
    reduced,
    room_graph,
    sources,
)
from import_graph import PACKAGE as ROOT

import asmc_pin

# Part -> parts that it may import. A part may only name parts above its own row, so that there is no way back.
# What stands in OPEN is open to all. Of the controllers the plant knows what it exchanges with them, and s
# to log.
MAY_IMPORT: dict[str, set[str]] = {
    "_typing": set(),
    "errors": set(),
    "lazy": set(),
    "clock": set(),
    "registering": set(),
    "statistics": set(),
    "words": set(),
    "disk": set(),
    "parameters": set(),
    "logs": set(),
    "numerics": set(),
    "rigid_body": {"numerics"},
    "arms": {"rigid_body"},
    "controllers": {"parameters", "numerics"},
    "baselines": {"arms", "controllers", "parameters"},  # laws that may know the arm, to compare with
    "references": {"arms", "controllers", "parameters", "logs"},
    "condition": {"arms", "logs", "references", "rigid_body", "numerics"},
    "sampled": {"arms", "controllers", "references", "condition", "parameters", "rigid_body", "numerics"},
    "identification": {"arms", "logs", "condition"},
    "plant": {
        "arms",
        "rigid_body",
        "numerics",
        "parameters",
        "controllers.protocol",
        "controllers.one_trial",
        "controllers.tde.sliding_variable",
    },
    "engine": {"arms", "controllers", "references", "plant"},
    "agreement": {"arms", "controllers", "plant", "engine"},
    "metrics": {"engine"},
    "tool_error": {"arms", "engine"},
    "tool_path": {"arms", "engine"},
    "monitors": {"arms", "controllers", "condition", "plant", "engine", "rigid_body"},
    "experiment": {
        "arms",
        "controllers",
        "baselines",
        "references",
        "condition",
        "plant",
        "metrics",
        "parameters",
    },
    "log_rerun": {
        "logs",
        "identification",
        "condition",
        "controllers.protocol",
        "references",
        "plant",
        "engine",
        "experiment",
    },
    "results": {"arms", "references", "plant", "engine", "metrics", "monitors", "experiment", "statistics"},
    "viewer": {"arms", "metrics", "experiment", "results"},
    "inspection": {"arms", "viewer"},
    "codegen": {
        "arms",
        "controllers",
        "condition.checker",
        "condition.hypotheses",
        "plant",
        "engine",
        "metrics",
        "experiment",
    },
    "pages": {
        "arms",
        "controllers",
        "references",
        "condition",
        "sampled",
        "identification",
        "log_rerun",
        "logs",
        "metrics",
        "monitors",
        "experiment",
        "results",
        "viewer",
        "statistics",
    },
    "exploring": {"arms", "condition", "rigid_body", "viewer", "pages"},
}
EVERYTHING = {*MAY_IMPORT, "package"}
MAY_IMPORT["study"] = EVERYTHING
MAY_IMPORT["sweeping"] = EVERYTHING | {"study"}
MAY_IMPORT["tuning"] = EVERYTHING | {"study", "sweeping"}
MAY_IMPORT["suites"] = EVERYTHING | {"study", "sweeping", "tuning"}
MAY_IMPORT["reproduction"] = EVERYTHING | {"study", "sweeping"}
MAY_IMPORT["cli"] = EVERYTHING | {"study", "sweeping", "tuning", "suites", "reproduction"}
MAY_IMPORT["package"] = EVERYTHING | {
    "study",
    "sweeping",
    "tuning",
    "suites",
    "reproduction",
    "cli",
}  # asmc_pin/__init__.py, the public names

OUTERMOST = ("study", "sweeping", "tuning", "suites", "reproduction", "cli", "package")

# The only modules with a control law in them that may see an arm; what they compute is marked "knows the model".
KNOW_THE_MODEL = {
    "asmc_pin.baselines.model_law",
    "asmc_pin.baselines.computed_torque",
    "asmc_pin.baselines.pd_gravity",
    "asmc_pin.baselines.slotine_li",
}

# Libraries with one home, so that what it costs to change them is known.
HOME = {
    "pinocchio": {"arms", "plant"},
    "coal": {"exploring"},
    "meshcat": {"viewer"},
    "matplotlib": {"pages", "reproduction"},
    "cvxpy": {"condition", "identification"},
    "pydantic": {"experiment", "condition"},
    "flint": {"condition"},
    "optuna": {"study", "tuning"},
    "mujoco": {"agreement", "arms"},  # arms: its reader of MJCF
    "joblib": {"sweeping"},
    "distributed": {"sweeping"},
    "typer": {"cli"},
}


def part_of(module: str) -> str:
    """The part of asmc_pin that a module or a name within it belongs to; `package` for names of asmc_pin itself."""
    names = module.split(".")
    known = len(names) > 1 and ((ROOT / names[1]).is_dir() or (ROOT / f"{names[1]}.py").is_file())
    return names[1] if known else "package"


def is_allowed(target: str, part: str) -> bool:
    other = part_of(target)
    below = ".".join(target.split(".")[1:])
    return other in {part} | OPEN | MAY_IMPORT[part] or any(
        below == name or below.startswith(f"{name}.") for name in MAY_IMPORT[part] if "." in name
    )


def test_every_part_has_its_place_in_the_flow() -> None:
    parts = {part_of(module) for module in sources()}
    assert parts <= set(MAY_IMPORT), f"give {sorted(parts - set(MAY_IMPORT))} a row in MAY_IMPORT of {__file__}"


def test_the_flow_has_no_way_back() -> None:
    above: set[str] = set()
    for part, allowed in MAY_IMPORT.items():
        # The names of the package itself (its version, its public names) are for the outermost parts only.
        outermost = {"package"} if part in OUTERMOST else set()
        assert {name.split(".")[0] for name in allowed} - above <= outermost
        above.add(part)


@pytest.mark.parametrize("part", MAY_IMPORT)
def test_a_part_imports_only_from_the_parts_before_it(part: str) -> None:
    wrong = [
        f"{path.relative_to(ROOT.parent)} imports {target}"
        for module, path in sources().items()
        if part_of(module) == part
        for target in sorted(imports_of(module))
        if target.split(".")[0] == "asmc_pin" and not is_allowed(target, part)
    ]
    assert not wrong


def test_the_checker_of_certificates_shares_nothing_with_the_prover_but_the_file() -> None:
    own = "asmc_pin.condition.checker"
    shared = (
        "asmc_pin.condition.certificate.container",
        "asmc_pin.condition.hypotheses",
        *(f"asmc_pin.{name}" for name in ("_typing", "errors", "lazy", "words.text")),
    )
    seen = {
        target
        for module, path in sources().items()
        if f"{module}.".startswith(f"{own}.")
        for target in imports_of(module)
        if target.split(".")[0] in ("asmc_pin", "pinocchio", "numba", "scipy", "cvxpy")
    }
    wrong = {target for target in seen if not any(f"{target}.".startswith(f"{name}.") for name in (own, *shared))}
    assert not wrong
    # That there is something to see.
    assert any(target.startswith(shared[0]) for target in seen)


def test_balls_know_nothing_of_the_bounds_of_boxes() -> None:
    own = "asmc_pin.condition.checker.balls"
    modules = [(module, path) for module, path in sources().items() if f"{module}.".startswith(f"{own}.")]
    assert len(modules) > 2
    wrong = [
        f"{module} imports {target}"
        for module, path in modules
        for target in imports_of(module)
        if f"{target}.".startswith("asmc_pin.condition.checker.boxes.")
    ]
    assert not wrong


def test_control_laws_see_numpy_and_numba_and_nothing_of_the_arm() -> None:
    compiled = {"numba", "llvmlite"}
    allowed = (sys.stdlib_module_names - {"importlib", "ctypes", "subprocess", "socket"}) | {"numpy"} | compiled
    open_to_laws = ("errors", "_typing", "parameters", "registering", "numerics.short_loops", "controllers")
    own = [f"asmc_pin.{name}" for name in open_to_laws]
    wrong = [
        f"{path.name} imports {target}"
        for module, path in sources().items()
        if part_of(module) == "controllers"
        for target in imports_of(module)
        if target.split(".")[0] not in allowed and not any(f"{target}.".startswith(f"{name}.") for name in own)
    ]
    assert not wrong


def has_a_law(path: Path) -> bool:
    """Whether the module defines a class with ``step(self, state, sample, setpoint)``, or with a `trial_step`."""
    classes = [node for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))) if isinstance(node, ast.ClassDef)]
    methods = [item for node in classes for item in node.body if isinstance(item, ast.FunctionDef)]
    named = [item.target for node in classes for item in node.body if isinstance(item, ast.AnnAssign)]
    if any(isinstance(name, ast.Name) and name.id == "trial_step" for name in named):
        return True
    return any(m.name == "step" and [a.arg for a in m.args.args][-2:] == ["sample", "setpoint"] for m in methods)


def test_of_all_laws_only_those_named_here_may_see_an_arm() -> None:
    laws = {module for module, path in sources().items() if has_a_law(path)}
    assert laws >= {"asmc_pin.controllers.baek2016", *KNOW_THE_MODEL}
    seeing = {
        module
        for module, path in sources().items()
        if module in laws and any(part_of(target) in ("arms", "baselines", "plant") for target in imports_of(module))
    }
    assert seeing == KNOW_THE_MODEL


@pytest.mark.parametrize("library", HOME)
def test_a_library_is_imported_only_where_it_is_at_home(library: str) -> None:
    wrong = [
        f"{path.relative_to(ROOT.parent)} imports {target}"
        for module, path in sources().items()
        for target in imports_of(module)
        if target.split(".")[0] == library and part_of(module) not in HOME[library]
    ]
    assert not wrong


def test_a_law_runs_in_a_process_that_never_loads_the_arm() -> None:
    code = "import sys, asmc_pin.controllers; print(*sorted({m.split('.')[0] for m in sys.modules}))"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    assert "numpy" in loaded
    assert not {"pinocchio", "yourdfpy", "pandas", "typer"} & set(loaded)


# The rooms as they stand on disk --------------------------------------------------------------------------------------

MOST_FILES = 16


def test_no_files_import_each_other_in_a_circle() -> None:
    graph = file_graph()
    assert len(graph) > 200
    assert not circles(graph)
    assert not circles(room_graph())


def test_no_folder_has_more_files_than_one_can_overlook() -> None:
    assert not {folder: count for folder, count in folders() if count > MOST_FILES}


def test_every_room_says_what_comes_in_and_what_goes_out() -> None:
    for folder, count in folders():
        if count and folder not in ("asmc_pin", "asmc_pin/cli/commands"):
            told = " ".join(docstring(folder.replace("/", ".")))
            assert re.search(r"\bTakes .*; gives ", told), folder


def test_no_two_files_have_one_name() -> None:
    names = Counter(path.name for path in sources().values() if path.name != "__init__.py")
    assert not {name for name, count in names.items() if count > 1}


def test_no_two_classes_have_one_name() -> None:
    trees = (ast.parse(path.read_text(encoding="utf-8")) for path in sources().values())
    names = Counter(node.name for tree in trees for node in tree.body if isinstance(node, ast.ClassDef))
    assert len(names) > 200
    assert not {name for name, count in names.items() if count > 1 and not name.startswith("_")}


def test_no_file_has_the_name_of_a_public_function_or_class() -> None:
    for package in (name for name, path in sources().items() if path.name == "__init__.py"):
        modules = {name.rpartition(".")[2] for name in sources() if name.rpartition(".")[0] == package}
        assert not modules & {target.rpartition(".")[2] for target in imports_of(package) if target not in sources()}
    assert not {name.rpartition(".")[2] for name in sources() if "." in name} & set(asmc_pin.__all__)


@pytest.mark.parametrize(
    ("graph", "found"),
    [
        ({"a": ["b"], "b": ["c"], "c": []}, []),
        ({"a": ["b"], "b": ["a"], "c": ["a"]}, [["a", "b"]]),
        ({"a": ["b"], "b": ["c"], "c": ["a", "d"], "d": ["e"], "e": ["d"]}, [["d", "e"], ["a", "b", "c"]]),
    ],
)
def test_a_circle_is_seen(graph: dict[str, list[str]], found: list[list[str]]) -> None:
    assert circles(graph) == found


def test_an_arrow_that_a_longer_way_makes_plain_is_left_out() -> None:
    graph = {"a": ["b", "c", "d"], "b": ["c"], "c": [], "d": []}
    assert reduced(graph) == {"a": {"b", "d"}, "b": {"c"}, "c": set(), "d": set()}
    assert layers(graph) == [["c", "d"], ["b"], ["a"]]


# That the reading above can fail -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("source", "found"),
    [
        ("import pinocchio as pin", "pinocchio"),
        ("def f():\n    from pinocchio import crba", "pinocchio.crba"),
        ("if TYPE_CHECKING:\n    import asmc_pin.plant", "asmc_pin.plant"),
        ("from asmc_pin import plant", "asmc_pin.plant"),
        ("from ..plant import Plant", "asmc_pin.plant.Plant"),
        ("from .. import plant", "asmc_pin.plant"),
        ("from . import protocol", "asmc_pin.controllers.protocol"),
        ("import importlib\nimportlib.import_module('pinocchio')", "pinocchio"),
        ("__import__('pinocchio')", "pinocchio"),
    ],
)
def test_every_form_of_import_is_seen(source: str, found: str) -> None:
    assert found in imports(source, "asmc_pin.controllers.ppc", is_package=False)


def test_a_relative_import_in_a_package_starts_from_the_package() -> None:
    assert imports("from .ppc import Ppc", "asmc_pin.controllers", is_package=True) == {"asmc_pin.controllers.ppc.Ppc"}


@pytest.mark.parametrize(
    ("target", "part", "allowed"),
    [
        ("asmc_pin.plant.Plant", "controllers", False),
        ("asmc_pin.engine.rollout", "pages", False),
        ("asmc_pin.plant", "viewer", False),
        ("asmc_pin.load_arm", "controllers", False),
        ("asmc_pin.controllers.protocol.Sample", "plant", True),
        ("asmc_pin.controllers.ppc.Ppc", "plant", False),
        ("asmc_pin.errors.ParameterError", "controllers", True),
        ("asmc_pin.arms.Arm", "condition", True),
        ("asmc_pin.condition", "arms", False),
    ],
)
def test_the_flow_forbids_what_it_is_meant_to_forbid(target: str, part: str, allowed: bool) -> None:
    assert is_allowed(target, part) is allowed
