"""The static page: one file, the same bytes for the same scene, and nothing in it that a label could break."""

from __future__ import annotations

import base64
import dataclasses
import json
import os
import re
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
import umsgpack
from paths import DOCS
from viewer_cases import HOSTILE, awkward_result, swing

from asmc_pin.arms import load_arm
from asmc_pin.errors import ParameterError, ResultError
from asmc_pin.results.result_folder import Result, load_result
from asmc_pin.viewer import PlayedMotion, describe, draw, replay_element, replay_html, replay_page, write_replay


@pytest.fixture(scope="module")
def result() -> Result:
    return awkward_result()


class Scripts(HTMLParser):
    """Collects what a browser takes for scripts, and every address that the page names."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.scripts: list[tuple[str | None, str]] = []
        self.addresses: list[str] = []
        self.headings: list[str] = []
        self._kind: str | None = None
        self._inside: str | None = None
        self.feed(page)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        named = dict(attrs)
        self._inside = tag
        if tag == "script":
            self.scripts.append((named.get("type"), ""))
        if tag == "h1":
            self.headings.append("")
        self.addresses += [value or "" for name, value in attrs if name in ("src", "href", "action", "data")]

    def handle_endtag(self, tag: str) -> None:
        self._inside = None

    def handle_data(self, data: str) -> None:
        if self._inside == "script":
            kind, text = self.scripts[-1]
            self.scripts[-1] = (kind, text + data)
        if self._inside == "h1":
            self.headings[-1] += data


def described(page: str) -> dict:
    return json.loads(next(text for kind, text in Scripts(page).scripts if kind == "application/json"))


def test_labels_and_names_cannot_break_out_of_the_page(result: Result) -> None:
    found = Scripts(replay_html(result))
    assert [kind for kind, _ in found.scripts] == ["application/json", "text/plain", *[None] * 5]
    assert Scripts(replay_page("a <b>&amp; title", "", "")).headings == ["a <b>&amp; title"]
    assert described(replay_html(result))["motions"][0]["label"] == HOSTILE
    assert not any("alert(1)" in text for kind, text in found.scripts if kind is None)


def test_the_page_names_no_address_outside_itself(result: Result) -> None:
    assert all(address.startswith("data:") for address in Scripts(replay_html(result)).addresses)


def test_the_same_result_gives_the_same_bytes_in_another_process(result: Result) -> None:
    script = (
        "import sys; from asmc_pin.results.result_folder import load_result; from asmc_pin.viewer import replay_html; "
        "sys.stdout.buffer.write(replay_html(load_result(sys.argv[1])).encode())"
    )
    seed = "1" if os.environ.get("PYTHONHASHSEED") != "1" else "2"
    other = subprocess.run(
        [sys.executable, "-c", script, str(result.path)],
        env={**os.environ, "PYTHONHASHSEED": seed},
        capture_output=True,
        check=True,
    )
    assert other.stdout == replay_html(result).encode()


def test_a_ur5_page_with_four_controllers_can_be_mailed() -> None:
    arm = load_arm("ur5")
    time = np.arange(0.0, 8.0, 0.002)
    wave = np.sin(time[:, None] * np.arange(1, 7))
    motions = [PlayedMotion(str(k), "#000000", wave + 0.01 * k) for k in range(4)]
    drawn = draw(arm)
    page = replay_page("demo", "", replay_element(describe(drawn, arm.joint_names, time, motions, wave)))
    assert len(page.encode()) < 4e6


def test_meshcat_gets_back_the_mesh_that_was_packed() -> None:
    drawn = draw(load_arm("ur5"), triangles=2000)
    description = describe(
        drawn, load_arm("ur5").joint_names, np.zeros(1), [PlayedMotion("", "#000", np.zeros((1, 6)))], None
    )
    for body, command in zip(drawn.bodies, description["commands"], strict=True):
        unpacked = umsgpack.unpackb(base64.b64decode(command))
        assert unpacked["type"] == "set_object"
        data = unpacked["object"]["geometries"][0]["data"]
        raw = data["attributes"]["position"]["array"].data
        step = unpacked["object"]["object"]["matrix"][0]
        positions = np.frombuffer(raw, dtype="<i2").reshape(-1, 3) * step
        np.testing.assert_allclose(positions, body.mesh.vertices, atol=0.6 * step)
        assert step < 5e-5
        faces = np.frombuffer(data["index"]["array"].data, dtype="<u2").reshape(-1, 3)
        np.testing.assert_array_equal(faces, body.mesh.faces)


def frames(description: dict, index: int) -> np.ndarray:
    raw = base64.b64decode(description["motions"][index]["q"])
    return np.frombuffer(raw, dtype="<f4").reshape(-1, len(description["joints"]))


def test_frames_are_few_and_lie_on_the_motion() -> None:
    description = swing(duration=2.0)
    q = frames(description, 0)
    assert len(q) == 121, "60 per second"
    time = np.linspace(0.0, 2.0, 121)
    joint = np.arange(6)
    true = 0.6 * np.sin(time[:, None] * (1.0 + 0.3 * joint)) + 0.01 * np.sin(5.0 * time[:, None] + joint)
    np.testing.assert_allclose(q, true, atol=1e-4)


def test_a_long_motion_gets_fewer_frames_per_second() -> None:
    arm = load_arm("two_link")
    time = np.linspace(0.0, 1000.0, 5001)
    motion = PlayedMotion("", "#000000", np.zeros((5001, 2)))
    description = describe(draw(arm, 500), arm.joint_names, time, [motion], None)
    assert len(frames(description, 0)) == 6001


def test_after_a_divergence_the_arm_stays_where_it_last_was() -> None:
    description = swing()
    q = frames(description, 1)
    assert np.isfinite(q).all()
    np.testing.assert_array_equal(q[61:], np.broadcast_to(q[60], q[61:].shape))
    assert description["motions"][1]["end"] == 1.0


def test_motions_of_a_wrong_size_are_refused() -> None:
    arm = load_arm("two_link")
    with pytest.raises(ParameterError, match=r"'lopsided' has shape \(3, 1\), expected \(3, 2\)"):
        describe(
            draw(arm, 500), arm.joint_names, np.arange(3.0), [PlayedMotion("lopsided", "#000", np.zeros((3, 1)))], None
        )


def test_a_result_of_a_lost_or_changed_arm_is_refused_in_words(result: Result, tmp_path: Path) -> None:
    import shutil

    copy = tmp_path / "copy"
    shutil.copytree(result.path, copy)
    # As a stranger's, without the hashes by which the change would be noticed first.
    provenance = json.loads((copy / "provenance.json").read_text())
    del provenance["files"]
    (copy / "provenance.json").write_text(json.dumps(provenance))
    experiment = (copy / "experiment.toml").read_text()
    (copy / "experiment.toml").write_text(re.sub('"two_link"', '"gone.urdf"', experiment))
    with pytest.raises(ResultError, match=r"cannot be loaded any more: .*gone\.urdf"):
        replay_html(load_result(copy))
    (copy / "experiment.toml").write_text(re.sub('"two_link"', '"double_pendulum"', experiment))
    with pytest.raises(ResultError, match="run the comparison again"):
        replay_html(load_result(copy))


def test_a_changed_urdf_is_told(result: Result) -> None:
    changed = Result(
        result.path, result.experiment, result.dataset, result.summary, {"arm": {"name": "two_link", "sha256": "0"}}
    )
    assert "The URDF has changed since the run" in replay_html(changed)
    assert "The URDF has changed since the run" not in replay_html(result)


def test_a_trial_that_is_not_there_is_refused(result: Result) -> None:
    with pytest.raises(ResultError, match="has no trial 3; it has 1, counted from 0"):
        replay_html(result, trial=3)


def test_a_page_that_cannot_be_written_is_told(result: Result, tmp_path: Path) -> None:
    with pytest.raises(ResultError, match="cannot be written: No such file or directory"):
        write_replay(result, tmp_path / "nowhere" / "page.html")


def test_the_example_of_the_docs_makes_a_page(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    text = (DOCS / "viewer.md").read_text(encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    exec(re.search(r"```python\n(.*?)```", text, re.DOTALL).group(1), {})
    page = (tmp_path / "panda.html").read_text(encoding="utf-8")
    assert described(page)["motions"][0]["label"] == "mine"
    assert len(page) < 2.5e6


def test_many_controllers_do_not_make_a_scene_that_no_browser_can_draw(result: Result) -> None:
    import xarray as xr

    many = xr.concat([result.dataset] * 100, dim="controller", data_vars="minimal")
    many = many.assign_coords(controller=[str(k) for k in range(200)])
    description = described(replay_html(dataclasses.replace(result, dataset=many)))
    faces = 0
    for command in description["commands"]:
        data = umsgpack.unpackb(base64.b64decode(command))["object"]["geometries"][0]["data"]
        faces += len(data["index"]["array"].data) // 6
    assert 400 * faces <= 480_000
