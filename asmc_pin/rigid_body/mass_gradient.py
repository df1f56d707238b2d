"""The gradient of xᵀ M(q) y by the joint values, compiled."""

from __future__ import annotations

from asmc_pin._typing import Array
from asmc_pin.rigid_body.recursion import Links, Placed, Vector, add, compiled, cross, dot, momentum


@compiled
def _twist(rate: float, slides: bool, s: Vector) -> tuple[Vector, Vector]:
    """Angular velocity, and velocity at the joint's origin, that a joint adds."""
    v = (rate * s[0], rate * s[1], rate * s[2])
    zero = (0.0, 0.0, 0.0)
    return (zero, v) if slides else (v, zero)


@compiled
def bilinear_gradient(links: Links, placed: Placed, x: Array, y: Array, flow: Array, out: Array) -> None:
    """∂(xᵀ M(q) y)/∂q_k for every k, by a pass outward and a pass inward for x and for y each.

    xᵀMy = Σ_j Vx_jᵀ I_j Vy_j. Moving joint k turns all bodies beyond it rigidly, which is the same as turning the
    velocity that enters them by the opposite motion: −S_k × V_k. So the derivative is
    −(S_k × Vx_k)·Py_k − (S_k × Vy_k)·Px_k, with P_k the momentum of the subtree. A coordinate that several joints
    follow gets the sum of theirs, by their ratios.

    Args:
        links: The tree.
        placed: Composite bodies, as `fill_mass` leaves them.
        x: Shape (nv,).
        y: Shape (nv,).
        flow: Scratch, shape (2, n, 12), n joints: velocity and momentum at each joint's origin, angular before linear.
        out: Receives the gradient, shape (nv,).
    """
    n = links.parent.size
    parent, prismatic, a, d = links.parent, links.prismatic, placed.a, placed.d
    coordinate, ratio = links.coordinate, links.ratio
    for side in range(2):
        rate = x if side == 0 else y
        f = flow[side]
        for i in range(n):
            w, u = _twist(ratio[i] * rate[coordinate[i]], prismatic[i], (a[i, 0], a[i, 1], a[i, 2]))
            p = parent[i]
            if p >= 0:
                turning = (f[p, 0], f[p, 1], f[p, 2])
                w = add(w, turning)
                u = add(u, add((f[p, 3], f[p, 4], f[p, 5]), cross(turning, (d[i, 0], d[i, 1], d[i, 2]))))
            f[i, 0], f[i, 1], f[i, 2] = w
            f[i, 3], f[i, 4], f[i, 5] = u
            for k in range(6, 12):
                f[i, k] = 0.0
        # The subtree's momentum: its composite as the joint's parent moves it, and what each joint in it adds.
        for i in range(n - 1, -1, -1):
            w, u = _twist(ratio[i] * rate[coordinate[i]], prismatic[i], (a[i, 0], a[i, 1], a[i, 2]))
            moment, linear = momentum(placed, i, w, u)
            moment, linear = add(moment, (f[i, 6], f[i, 7], f[i, 8])), add(linear, (f[i, 9], f[i, 10], f[i, 11]))
            p = parent[i]
            if p >= 0:
                carried = add(moment, cross((d[i, 0], d[i, 1], d[i, 2]), linear))
                f[p, 6], f[p, 7], f[p, 8] = add(carried, (f[p, 6], f[p, 7], f[p, 8]))
                f[p, 9], f[p, 10], f[p, 11] = add(linear, (f[p, 9], f[p, 10], f[p, 11]))
            carrying = (f[i, 0] - w[0], f[i, 1] - w[1], f[i, 2] - w[2])
            rigid, pushed = momentum(placed, i, carrying, (f[i, 3] - u[0], f[i, 4] - u[1], f[i, 5] - u[2]))
            f[i, 6], f[i, 7], f[i, 8] = add(moment, rigid)
            f[i, 9], f[i, 10], f[i, 11] = add(linear, pushed)
    for i in range(x.size):
        out[i] = 0.0
    for i in range(n):
        s = (a[i, 0], a[i, 1], a[i, 2])
        total = 0.0
        for side in range(2):
            v, m = flow[side, i], flow[1 - side, i]
            linear = (m[9], m[10], m[11])
            if prismatic[i]:
                total -= dot(cross(s, (v[0], v[1], v[2])), linear)
            else:
                total -= dot(cross(s, (v[0], v[1], v[2])), (m[6], m[7], m[8]))
                total -= dot(cross(s, (v[3], v[4], v[5])), linear)
        out[coordinate[i]] += ratio[i] * total
