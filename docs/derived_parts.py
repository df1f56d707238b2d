"""The parts of the documentation that are made from the code, by their names; docs/generate.py puts them in place.

A part is a function without arguments that returns Markdown. Words come from the code: from the meaning, unit and bound
that a parameter carries, from a class's title and equation, from the docstring of a room.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterable
from functools import cache

from import_graph import PACKAGE, docstring, folders, layers, room_graph
from law_oracles import ORACLES

from asmc_pin.arms import ARMS
from asmc_pin.arms.published_armature import PUBLISHED_ARMATURE
from asmc_pin.arms.robot_limits import LIMITED_QUANTITIES, ROBOT_LIMITS
from asmc_pin.baselines import BASELINES, ModelLaw
from asmc_pin.baselines.model_card import LIMITS, model_card
from asmc_pin.cli.commands.listing_commands import arm_rows, controller_rows, metric_rows
from asmc_pin.controllers import CONTROLLERS, TdeLaw
from asmc_pin.controllers.law_card import law_card, suggested
from asmc_pin.experiment.arm_keys import ArmTable
from asmc_pin.experiment.constructors import Signature
from asmc_pin.experiment.plant_parts import LISTS, TABLES
from asmc_pin.experiment.toml_keys import EnsembleTable, ExperimentTables, MetricsTable, PlantTable
from asmc_pin.experiment.toml_values import TomlTable
from asmc_pin.experiment.tune_table import LimitsTable, TuneTable
from asmc_pin.metrics import METRICS
from asmc_pin.monitors import STATEMENTS
from asmc_pin.pages.comparison_figures import FIGURES
from asmc_pin.parameters import REQUIRED, Parameter, parameters_of
from asmc_pin.plant import ORDERS
from asmc_pin.references import REFERENCES
from asmc_pin.reproduction.joint_figures import medians, plain_pair
from asmc_pin.sampled.stable_ratios import stable_words
from asmc_pin.words.media import for_cell

PARTS: dict[str, Callable[[], str]] = {}


def part(name: str) -> Callable[[Callable[[], str]], Callable[[], str]]:
    """Make a function the part of that name; made once, however many pages show it."""

    def register(make: Callable[[], str]) -> Callable[[], str]:
        PARTS[name] = cache(make)
        return make

    return register


def table(header: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    """A Markdown table of cells that are Markdown already."""
    header = list(header)
    lines = [header, ["---"] * len(header), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def plain(header: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    """A Markdown table of plain text."""
    return table(map(for_cell, header), ([for_cell(str(cell)) for cell in row] for row in rows))


def code(*names: str) -> str:
    """Names in the type of code."""
    return ", ".join(f"`{name}`" for name in names)


def prose(text: str) -> str:
    """Text of our own, which may hold code in backticks, as a cell."""
    return text.replace("|", r"\|").replace("<", "&lt;")


def default(value: object) -> str:
    """What a table says of a default."""
    if value is REQUIRED:
        return "required"
    if value is None:
        return ""
    if isinstance(value, bool):
        return f"`{str(value).lower()}`"  # as TOML has it
    if isinstance(value, (int, float)):
        return f"{value:g}"
    return f'`"{value}"`' if isinstance(value, str) else f"`{list(value)}`" if value else ""  # type: ignore[call-overload]


def parameter_rows(items: Iterable[Parameter], *first: str) -> list[list[str]]:
    """A row for each parameter: name, meaning, unit, what it takes, default."""
    return [
        [
            *first,
            code(item.name),
            prose(item.meaning),
            item.unit,
            re.sub(r'("\w+")', r"`\1`", prose(item.takes)),
            default(item.default),
        ]
        for item in items
    ]


PARAMETER = ("parameter", "meaning", "unit", "takes", "default")


# README.md ------------------------------------------------------------------------------------------------------------

part("arms")(lambda: plain(*arm_rows()))
part("controllers")(lambda: plain(*controller_rows()))
part("metrics")(lambda: plain(*metric_rows()))


@part("reproduced-rows")
def reproduced_rows() -> str:
    """README.md: what the page of the paper says of one table, with how sure it is."""
    data = json.loads((PACKAGE.parent / "docs" / "reproduction" / "reproduction.json").read_text(encoding="utf-8"))
    item = data["experiments"]["baek2016_simulation_smooth"]
    rows = (
        [label, plain_pair(item["paper"]["rms_deg"].get(label)), medians(run, "rms_deg")]
        for label, run in item["controllers"].items()
    )
    return plain(["controller", "paper", "measured"], rows)


# One page for each kind of thing --------------------------------------------------------------------------------------


@part("named-arms")
def named_arms() -> str:
    """docs/arms.md: what each arm is, and what its entry adds to the URDF."""
    rows = []
    for name, arm in ARMS.items():
        locked = ", ".join(f"{code(joint)} at {value:g}" for joint, value in arm.locks.items())
        rotors = ", ".join(f"{code(joint)} {value:g}" for joint, value in arm.armature.items())
        rows.append([code(name), prose(arm.description), locked or "none", rotors or "none"])
    return table(["name", "what it is", "locked unless freed, rad (m)", "armature of its own, kg·m²"], rows)


@part("published-armature")
def published_armature() -> str:
    """docs/arms.md: which reflected inertias are published, by whom, and how sure they are."""
    rows = []
    for name, known in PUBLISHED_ARMATURE.items():
        values = ", ".join(f"{code(joint)} {value:.9g}" for joint, value in known.armature.items())
        rows.append([code(name), values, prose(known.source), prose(known.certainty)])
    return table(["name", "reflected inertia, kg·m²", "source", "how sure"], rows)


@part("robot-limits")
def robot_limits() -> str:
    """docs/plant.md: what is published of each robot, and where."""
    rows = []
    for name, robot in ROBOT_LIMITS.items():
        sources: dict[str, list[str]] = {}
        cells = []
        for key, (words, _) in LIMITED_QUANTITIES.items():
            limit = robot.published.get(key)
            cells.append("not published" if limit is None else ", ".join(f"{x:.4g}" for x in limit.values))
            if limit is not None:
                sources.setdefault(limit.source, []).append(words)
        said = "; ".join(f"{', '.join(words)}: {source}" for source, words in sources.items())
        rows.append([code(name), prose(robot.robot), *cells, prose(said)])
    return table(
        ["name", "robot", *(f"{words}, {unit}" for words, unit in LIMITED_QUANTITIES.values()), "sources"], rows
    )


@part("metric-definitions")
def metric_definitions() -> str:
    """docs/metrics.md: everything that a metric says of itself."""
    header = ["key", "what tables call it", "unit", "best", "definition", "source"]
    rows = [
        [code(m.name), *map(for_cell, (m.title, m.unit, m.best or "–", m.formula, m.source))] for m in METRICS.values()
    ]
    return table(header, rows)


part("metric-settings")(lambda: fields(MetricsTable))


@part("tune-keys")
def tune_keys() -> str:
    """docs/tuning.md: the keys of ``[tune]``."""
    return table(["key", "value", "default"], _tune_rows())


def _tune_rows() -> list[list[str]]:
    return _field_rows(TuneTable, "tune.") + _field_rows(LimitsTable, "tune.limits.")


@part("shared-parameters")
def shared_parameters() -> str:
    """docs/controllers.md: what every TDE law takes."""
    return table(PARAMETER, parameter_rows(parameters_of(TdeLaw).values()))


@part("law-parameters")
def law_parameters() -> str:
    """docs/controllers.md: what each TDE law takes besides."""
    shared = parameters_of(TdeLaw)
    rows = []
    for name, law in CONTROLLERS.items():
        rows += parameter_rows((item for key, item in parameters_of(law).items() if key not in shared), code(name))
    return table(["law", *PARAMETER], rows)


@part("model-law-parameters")
def model_law_parameters() -> str:
    """docs/controllers.md: what the laws that know the model take; first what all of them do."""
    shared = {key: item for key, item in parameters_of(ModelLaw).items() if key != "period"}
    rows = parameter_rows(shared.values(), "all of them")
    for name, law in BASELINES.items():
        own = (item for key, item in parameters_of(law).items() if key not in parameters_of(ModelLaw))
        rows += parameter_rows(own, code(name))
    return table(["law", *PARAMETER], rows)


part("law-equations")(
    lambda: table(
        ["law", "what it is", "equation", "source"],
        (
            [code(name), *map(for_cell, (law.title, law.equation, law.reference))]
            for name, law in (CONTROLLERS | BASELINES).items()
        ),
    )
)


@part("law-oracles")
def law_oracles_table() -> str:
    """docs/laws.md: what each law has to do, and what was measured through the plant."""
    rows = ([code(item.law), prose(item.property), prose(item.must), prose(item.shown())] for item in ORACLES)
    return table(["law", "property", "what it has to be", "measured"], rows)


@part("law-cards")
def law_cards() -> str:
    """docs/law_cards.md: every law on one page."""
    cards = [
        [*law_card(name, law).lines(), f"Limits: {stable_words(suggested(law))}"] for name, law in CONTROLLERS.items()
    ]
    cards += [[*model_card(name).lines(), f"Limits: {LIMITS}"] for name in BASELINES]
    return "\n\n".join("\n".join([f"## {lines[0]}", "", "```text", *lines[2:], "```"]) for lines in cards)


@part("reference-kinds")
def reference_kinds() -> str:
    """docs/references.md: the kinds, and what each takes."""
    rows = ([code(kind), prose(cls.motion), code(*Signature(cls).names)] for kind, cls in REFERENCES.items())
    return table(["kind", "motion", "parameters"], rows)


@part("reference-parameters")
def reference_parameters() -> str:
    """docs/references.md: every parameter of every kind."""
    rows = []
    for kind, cls in REFERENCES.items():
        rows += parameter_rows(parameters_of(cls).values(), code(kind))
    return table(["kind", *PARAMETER], rows)


def plant_part(cls: type) -> Callable[[], str]:
    """docs/plant.md: the keys of a table of ``[plant]``."""
    return lambda: table(("key", *PARAMETER[1:]), parameter_rows(parameters_of(cls).values()))


for _key, _cls in (TABLES | LISTS).items():
    part(f"plant-{_key.replace('_', '-')}")(plant_part(_cls))

part("integrator-orders")(lambda: table(["scheme", "order"], ([code(name), str(n)] for name, n in ORDERS.items())))
part("claims")(
    lambda: table(
        ["claim", "what it says", "unit of what breaks it", "asked of"],
        ([*map(for_cell, (s.title, s.text, s.unit, s.asked_of))] for s in STATEMENTS.values()),
    )
)


# docs/experiments.md --------------------------------------------------------------------------------------------------


def fields(model: type[TomlTable], path: str = "", skip: Iterable[str] = ()) -> str:
    """The keys of a table of the file: path, meaning, default."""
    return table(["key", "value", "default"], _field_rows(model, path, skip))


def _field_rows(model: type[TomlTable], path: str, skip: Iterable[str] = ()) -> list[list[str]]:
    rows = []
    for name, field in model.model_fields.items():
        if name in skip:
            continue
        made = field.default_factory is not None  # a table, whose keys stand in rows of their own
        value = REQUIRED if field.is_required() else None if made else field.default
        rows.append([code(f"{path}{name}"), prose(field.description or ""), default(value)])
    return rows


@part("experiment-keys")
def experiment_keys() -> str:
    """Every key whose name does not depend on a law or a kind."""
    rows = _field_rows(
        ExperimentTables, "", skip=("plant", "ensemble", "metrics", "tune", "reference", "defaults", "controllers")
    )
    rows += _field_rows(ArmTable, "arm.") + _field_rows(PlantTable, "plant.")
    rows += _field_rows(EnsembleTable, "ensemble.") + _field_rows(MetricsTable, "metrics.")
    rows += _tune_rows()
    return table(["key", "value", "default"], rows)


@part("kinds-and-laws")
def kinds_and_laws() -> str:
    """The keys whose values name something that is registered."""
    rows = [
        [code("reference.kind"), f"{code(*REFERENCES)}; the other keys are that kind's", "required"],
        [code("defaults.…"), "any parameter of a law, but `law` and `period`; a law takes those that it has", ""],
        [code("controllers.LABEL.law"), f"{code(*CONTROLLERS, *BASELINES)}, or `my_module:MyLaw`", "required"],
        [code("controllers.LABEL.…"), "parameters of the law; they override `[defaults]`", ""],
    ]
    return table(["key", "value", "default"], rows)


part("figures")(lambda: table(["figure", "shows"], ([code(n), prose(d.caption)] for n, d in FIGURES.items())))


# The rooms ------------------------------------------------------------------------------------------------------------


@part("rooms")
def rooms() -> str:
    """CONTRIBUTING.md: one line for each room, from the bottom up."""
    names = [room for row in layers(room_graph()) for room in row]
    shown = [code(room if (PACKAGE / room).is_dir() else f"{room}.py") for room in names]
    said = [prose(docstring(f"{PACKAGE.name}.{room}")[0]) for room in names]
    return table(["room", "what it is"], ([*pair] for pair in zip(shown, said, strict=True)))


@part("rooms-folders")
def rooms_folders() -> str:
    """docs/rooms.md: every folder, how many files it holds, and what it says of itself."""
    rows = (
        [code(folder), str(count), prose(" ".join(docstring(folder.replace("/", "."))[:2]))]
        for folder, count in folders()
    )
    return table(["folder", "files", "what it says"], rows)
