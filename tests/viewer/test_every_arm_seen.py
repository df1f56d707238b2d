"""Every shipped arm and the odd ones of the tests as a browser draws them: whole, large enough, each link in its place.

`python viz/contact_sheet.py` makes the picture of the shipped ones that a person looks at.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from arm_urdf import write
from browser import Browser, Page, shared_browser
from coupled_urdf import coupled_tree, gripper, parallelogram
from urdf_kinds import KINDS
from viewer_cases import BENT

from asmc_pin import Arm
from asmc_pin.arms import arm_names, load_arm
from asmc_pin.viewer import PlayedMotion, describe, draw, replay_element, replay_page
from asmc_pin.viewer.drawing.drawn_bodies import attachments

pytestmark = pytest.mark.filterwarnings("ignore::asmc_pin.viewer.drawing.drawn_bodies.DrawingWarning")

TIME = 0.7
"""s, of the picture: at a frame of the motion, for between two of them the page goes straight."""

ODD = (
    *("seven joints", "torso with two arms", "one arm of a torso", "torso, one arm locked by pattern"),
    *("two arms on one base", "gantry", "scara", "rail", "one joint", "boxes that fit", "gripper locked"),
    *("gripper that mimics", "tilted axes of any length", "names with spaces", "lengths in mm", "meshes missing"),
)
"""Kinds that are drawn differently from each other; most of the others differ in their inertias alone."""

COUPLED: dict[str, Callable[[], str]] = {
    "parallelogram": parallelogram,
    "gripper": gripper,
    "random tree": lambda: coupled_tree(np.random.default_rng(2), joints=6, followers=3),
    "turning and sliding": lambda: BENT.format(upper="", lower=""),
}

BODIES = (
    "(() => { const { THREE } = MeshCat, { root, motions } = replays[0].stage.arms[0];"
    " return motions.map((node) => { const pose = new THREE.Matrix4();"
    " for (; node !== root; node = node.parent) { node.updateMatrix(); pose.premultiply(node.matrix); }"
    " return pose.toArray(); }); })()"
)
"""Poses of the bodies in the arm's frame, as the page's own nodes have them, column by column."""

SEEN = """(() => {
  const { stage } = replays[0], { viewer, canvas } = stage, [arm] = stage.arms, { meshes, root } = arm;
  stage.key.castShadow = false;
  stage.show({ paths: false });
  const gl = viewer.renderer.getContext(), { width, height } = canvas;
  const picture = () => {
    viewer.render();
    const pixels = new Uint8Array(4 * width * height);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
    return pixels;
  };
  root.visible = false;
  const empty = picture();
  root.visible = true;
  const box = (pixels) => {
    let count = 0, left = width, right = 0, low = height, high = 0;
    for (let k = 0; k < width * height; k++) {
      if ([0, 1, 2].every((c) => Math.abs(pixels[4 * k + c] - empty[4 * k + c]) < 6)) continue;
      const x = k % width, y = Math.floor(k / width);
      count += 1;
      [left, right] = [Math.min(left, x), Math.max(right, x)];
      [low, high] = [Math.min(low, y), Math.max(high, y)];
    }
    return { count, left, right: width - 1 - right, low, high: height - 1 - high, width, height };
  };
  const whole = box(picture());
  const alone = meshes.map((mesh) => {
    for (const other of meshes) other.visible = other === mesh;
    return box(picture()).count;
  });
  return { whole, alone };
})()"""
"""How many pixels the arm covers, how far it stays from the picture's edges, and what each link covers alone."""


@pytest.fixture(scope="module")
def browser() -> Browser:
    return shared_browser()


def opened(page: Page, arm: Arm, path: Path) -> None:
    time = np.linspace(0.0, 2.0, 401)
    drawn = draw(arm, 3000)
    motion = PlayedMotion("moves", "#0072B2", motion_of(arm, time))
    scene = describe(drawn, arm.joint_names, time, [motion], None)
    path.write_text(replay_page("", "", replay_element(scene)), encoding="utf-8")
    page.open(f"{path.as_uri()}#t={TIME}")
    assert page.messages == []


def motion_of(arm: Arm, time: object) -> np.ndarray:
    """About the middle of the ranges, a third of them wide."""
    lower, upper = (np.clip(end, -np.pi, np.pi) for end in arm.box)
    wave = np.sin(np.asarray(time)[..., None] * (1.0 + 0.3 * np.arange(arm.nv)))
    return (lower + upper) / 2 + (upper - lower) / 6 * wave


def links_stand_where_pinocchio_puts_them(page: Page, arm: Arm) -> None:
    poses = np.array(page.run(BODIES)).reshape(-1, 4, 4).transpose(0, 2, 1)
    links = arm.link_poses(motion_of(arm, TIME))
    size = max(1.0, float(np.abs(links[:, :3, 3]).max()))
    for link, (_, body, pose) in enumerate(attachments(arm)):
        np.testing.assert_allclose(poses[body] @ pose, links[link], atol=1e-4 * size)


def it_is_seen_whole_and_no_link_is_missing(page: Page) -> None:
    seen = page.run(SEEN)
    whole, alone = seen["whole"], seen["alone"]
    margins = [whole[side] for side in ("left", "right", "low", "high")]
    assert min(margins) > 0, f"cut off: {whole}"
    wide = 1.0 - (whole["left"] + whole["right"]) / whole["width"]
    tall = 1.0 - (whole["low"] + whole["high"]) / whole["height"]
    assert max(wide, tall) > 0.3, f"small: {whole}"
    assert min(alone) > 0, f"links that cover nothing: {alone}"


@pytest.mark.long
@pytest.mark.parametrize("name", [*arm_names(), *ODD, *COUPLED])
def test_each_arm_is_whole_and_its_links_are_where_they_belong(browser: Browser, name: str, tmp_path: Path) -> None:
    if name in KINDS:
        arm = load_arm(write(tmp_path, KINDS[name].text), **KINDS[name].options)
    else:
        arm = load_arm(write(tmp_path, COUPLED[name]()) if name in COUPLED else name)
    with browser.page(420, 360) as page:
        opened(page, arm, tmp_path / "arm.html")
        links_stand_where_pinocchio_puts_them(page, arm)
        it_is_seen_whole_and_no_link_is_missing(page)
