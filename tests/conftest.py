"""Tests of one module that share what is costly to make (a fixture of the module's scope) run in one process.

Where several processes run the suite, each would make it again, as soon as it got one of these tests.
"""

from collections.abc import Iterator

import pytest


def shared(item: pytest.Function) -> Iterator[str]:
    """Names of the fixtures that a test shares with others of its module."""
    for name, definitions in item._fixtureinfo.name2fixturedefs.items():
        if any(definition.scope == "module" for definition in definitions):
            yield name


@pytest.hookimpl(tryfirst=True)  # before xdist reads the groups
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """One group for each module with such fixtures; `--dist loadgroup` keeps a group together."""
    for item in items:
        if isinstance(item, pytest.Function) and any(shared(item)) and not item.get_closest_marker("xdist_group"):
            item.add_marker(pytest.mark.xdist_group(item.path.stem))
