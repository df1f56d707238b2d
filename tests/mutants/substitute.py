"""A pytest plugin that lets one module be imported from another text: that of a mutant.

``MUTANT_OF=asmc_pin/tool_error.py MUTANT=changed.py python -m pytest -p mutants.substitute …``
"""

from __future__ import annotations

import importlib.abc
import importlib.machinery
import importlib.util
import os
import sys
from collections.abc import Sequence
from pathlib import Path
from types import CodeType, ModuleType

_OF, _TEXT = Path(os.environ["MUTANT_OF"]).resolve(), Path(os.environ["MUTANT"]).read_text(encoding="utf-8")


class _Loader(importlib.machinery.SourceFileLoader):
    def get_code(self, fullname: str) -> CodeType:
        return compile(_TEXT, self.path, "exec")


class _Finder(importlib.abc.MetaPathFinder):
    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> importlib.machinery.ModuleSpec | None:
        spec = importlib.machinery.PathFinder.find_spec(fullname, path)
        if spec is None or spec.origin is None or Path(spec.origin).resolve() != _OF:
            return None
        changed = importlib.util.spec_from_file_location(
            fullname, spec.origin, loader=_Loader(fullname, spec.origin), submodule_search_locations=None
        )
        if changed is not None and spec.submodule_search_locations is not None:
            changed.submodule_search_locations = spec.submodule_search_locations
        return changed


sys.meta_path.insert(0, _Finder())
