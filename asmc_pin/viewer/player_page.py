"""The static page: Meshcat's own bundle, its commands and the player, in one file that opens without a network."""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import cache
from importlib.resources import files
from string import Template
from typing import Any

from asmc_pin.words.media import for_html

POLICY = (
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:; "
    "base-uri 'none'; form-action 'none'"
)
"""Content security policy of every page made here: a browser fetches nothing, whatever a result's labels say."""

_SCENE, _PLAYER = ("arm_view.js", "scene.js"), ("timeline.js", "player.js")
"""Scripts of the scene and of what plays in it, each needing those before it."""


def replay_page(title: str, subtitle: str, replay: str) -> str:
    """A page of its own around one replay.

    Args:
        title: Title, as plain text.
        subtitle: A line beside it, as plain text.
        replay: What `replay_element` returned.
    """
    return Template(static("page.html")).substitute(
        policy=POLICY,
        title=for_html(title),
        subtitle=for_html(subtitle),
        style=static("player.css"),
        replay=replay,
        scripts=player_scripts(),
    )


def replay_element(description: Mapping[str, Any], notes: tuple[str, ...] = (), *, embedded: bool = False) -> str:
    """The element that the player fills. A page may hold several, and needs `player_scripts` and ``player.css`` once.

    Args:
        description: What `motion.describe` returned.
        notes: Lines to stand above the picture, as plain text.
        embedded: It stands in a longer page: it waits for the user, and takes keys and the wheel only with the focus.
    """
    lines = "".join(f'<p class="replay-notes">{for_html(note)}</p>\n' for note in notes)
    return (
        f'<div class="replay" data-embedded="{str(embedded).lower()}">\n{lines}'
        '<p class="replay-message" role="alert" hidden></p>\n<div class="replay-stage"></div>\n'
        f'<script type="application/json">{json_text(description)}</script>\n</div>'
    )


@cache
def player_scripts() -> str:
    """What `scene_scripts` has, and the player, as script elements."""
    return "\n".join([scene_scripts(), *(f"<script>{inert(static(name))}</script>" for name in _PLAYER)])


@cache
def scene_scripts() -> str:
    """Meshcat's bundle, with its licences, and the scene, as script elements."""
    viewer = files("meshcat") / "viewer"
    licences = "\n\n".join(
        (viewer / name).read_text(encoding="utf-8") for name in ("LICENSE", "dist/main.min.js.LICENSE.txt")
    )
    bundle = (viewer / "dist" / "main.min.js").read_text(encoding="utf-8")
    scripts = [bundle, *map(static, _SCENE)]
    return "\n".join(
        [
            f'<script type="text/plain" id="meshcat-licences">\n{inert(licences)}\n</script>',
            *(f"<script>{inert(script)}</script>" for script in scripts),
        ]
    )


def static(name: str) -> str:
    """Text of a file that travels with the viewer."""
    return (files("asmc_pin.viewer") / "static" / name).read_text(encoding="utf-8")


def inert(script: str) -> str:
    """A script that cannot end its element early; in strings and patterns the added backslash changes nothing."""
    return script.replace("</script", "<\\/script").replace("<!--", "<\\!--")


def json_text(value: Mapping[str, Any]) -> str:
    """JSON that no label can break out of."""
    text = json.dumps(value, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    return text.replace("<", "\\u003c").replace("\u2028", "\\u2028").replace("\u2029", "\\u2029")
