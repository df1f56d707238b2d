"""The explorer's page, served to this machine: it asks whether links collide where the sliders are."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING
from urllib.parse import parse_qs

import numpy as np

from asmc_pin.condition.domain.joint_box import Box
from asmc_pin.errors import ParameterError
from asmc_pin.exploring.link_collisions import LinkCollisions
from asmc_pin.viewer.local_server import Answers, serve_page

if TYPE_CHECKING:
    from asmc_pin.arms import Arm


def serve_explorer(arm: Arm, page: str, box: Box, port: int = 0, *, open_browser: bool = False) -> None:
    """Serve it until Ctrl-C is pressed.

    Args:
        arm: The arm.
        page: HTML that says of itself that it is live.
        box: The joint box.
        port: On 127.0.0.1; 0 takes a free one.
        open_browser: Open it in the user's browser as well.

    Raises:
        ParameterError: The port is taken.
    """
    serve_page(page, port, what="explorer", open_browser=open_browser, answers=live_answers(arm, box))


def live_answers(arm: Arm, box: Box) -> Answers:
    """What the page may ask: ``/collisions?q=…``, one value per joint in rad (m where prismatic)."""
    collisions = LinkCollisions(arm, box)

    def collide(query: str) -> str:
        try:
            q = np.array([float(part) for part in parse_qs(query).get("q", [""])[0].split(",")])
        except ValueError:
            raise ParameterError("q", "numbers with commas between them expected") from None
        if q.shape != (arm.nv,) or not np.isfinite(q).all():
            raise ParameterError("q", f"{arm.nv} finite numbers expected")
        answer = collisions.at(q)
        return json.dumps({"known": answer.known, "pairs": answer.pairs, "text": answer.text})

    return {"/collisions": collide}
