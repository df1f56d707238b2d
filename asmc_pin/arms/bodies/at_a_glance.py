"""What a model says without any motion: axes with all joints at zero, and what each joint feels at least."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from asmc_pin._typing import Array


def axes_at_zero(model: pin.Model) -> tuple[Array, Array]:
    """Axes of the joints in the base frame and the places of their frames, m, all joints at zero; each (nv, 3)."""
    data = model.createData()
    pin.computeJointJacobians(model, data, np.zeros(model.nq))
    axes, places = np.empty((model.nv, 3)), np.empty((model.nv, 3))
    for joint in range(1, model.njoints):
        own = pin.getJointJacobian(model, data, joint, pin.LOCAL).reshape(6, model.nv)[:, model.idx_vs[joint]]
        along = own[:3] if np.any(own[:3]) else own[3:]
        pose = data.oMi[joint]
        axes[joint - 1] = pose.rotation @ along + 0.0
        places[joint - 1] = pose.translation
    return axes, places


def least_felt(model: pin.Model) -> Array:
    """The least diagonal of M(q) over a few configurations, shape (nv,), kg·m² (kg)."""
    data = model.createData()
    draws = np.random.default_rng(1).uniform(-np.pi, np.pi, (8, model.nv))
    found = [np.diag(pin.crba(model, data, q)) for q in np.vstack([np.zeros(model.nv), draws])]
    return np.asarray(np.min(found, axis=0))
