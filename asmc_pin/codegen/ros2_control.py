"""A ros2_control controller around the exported C: plugin, description, build files, parameters, README."""

from __future__ import annotations

import json
from pathlib import Path
from string import Template

from asmc_pin.codegen.exported_code import CodeText
from asmc_pin.words.media import for_html

_TEXTS = Path(__file__).parent / "ros2_text"
_FILES = {
    "controller.hpp.in": "{name}_controller.hpp",
    "controller.cpp.in": "{name}_controller.cpp",
    "plugin.xml.in": "{name}_plugin.xml",
    "controllers.yaml.in": "{name}_controllers.yaml",
    "CMakeLists.txt.in": "CMakeLists.txt",
    "package.xml.in": "package.xml",
    "README.md.in": "README.md",
}


def ros2_control_texts(code: CodeText) -> dict[str, str]:
    """The files that make a ROS 2 package of an export, by their names; written to the signatures of Jazzy."""
    words = {
        "name": code.name,
        "PREFIX": code.name.upper(),
        "heading": for_html(code.heading),
        # A quoted string of JSON is one of C++ and of YAML too.
        "joints": ", ".join(json.dumps(joint, ensure_ascii=False) for joint in code.joints),
        "rate": f"{1.0 / code.guard.period:.10g}",
    }
    return {
        written.format(name=code.name): Template((_TEXTS / text).read_text(encoding="utf-8")).substitute(words)
        for text, written in _FILES.items()
    }
