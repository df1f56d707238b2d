"""Claims about the figures that `inspect` shows: those of what was read, and none where there is none."""

import numpy as np
from arm_urdf import inertial, joint, link, robot, write

from asmc_pin import inspect


def test_a_payload_is_told_with_its_link_and_is_not_mixed_into_the_bodies():
    bare, loaded = (
        inspect("ur5"),
        inspect("ur5", payload={"mass": 20.0, "link": "wrist_3_link", "com": (0.0, 0.1, 0.0)}),
    )
    assert [joint.mass for joint in loaded.joints] == [joint.mass for joint in bare.joints]
    assert "carries 20 kg at (0, 0.1, 0) m on wrist_3_link, not counted below" in loaded.lines()
    assert loaded.to_json_dict()["payload"]["mass"] == 20.0
    assert bare.to_json_dict()["payload"] is None


def test_a_negative_mass_has_no_centre(tmp_path):
    parts = (link("base"), link("l", inertial(-1.0)), joint("j", "base", "l"))
    found = inspect(write(tmp_path, robot(*parts)))
    assert found.refusal
    assert np.isnan(found.joints[0].com).all()
    assert found.to_json_dict()["joints"][0]["body"]["com"] is None
    assert "e+" not in str(found)
