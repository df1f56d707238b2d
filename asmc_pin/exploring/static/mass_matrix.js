// M(q) of a tree of links by composite bodies, in float64: the numbers and the order of asmc_pin.rigid_body.recursion.
// Vectors are in the base's axes, each from its own joint's origin.
"use strict";
const AsmcMass = (() => {
  const dot = (a, i, b, j) => a[i] * b[j] + a[i + 1] * b[j + 1] + a[i + 2] * b[j + 2];

  // out[o…] = R[r…] x[i…], with R row by row.
  const turn = (R, r, x, i, out, o) => {
    const x0 = x[i], x1 = x[i + 1], x2 = x[i + 2];
    for (let k = 0; k < 3; k++) out[o + k] = R[r + 3 * k] * x0 + R[r + 3 * k + 1] * x1 + R[r + 3 * k + 2] * x2;
  };

  const product = (A, a, B, b, out, o) => {
    for (let i = 0; i < 3; i++) {
      for (let j = 0; j < 3; j++) {
        out[o + 3 * i + j] = A[a + 3 * i] * B[b + j] + A[a + 3 * i + 1] * B[b + 3 + j] + A[a + 3 * i + 2] * B[b + 6 + j];
      }
    }
  };

  const cross = (a, i, b, j, out, o) => {
    const x = a[i + 1] * b[j + 2] - a[i + 2] * b[j + 1], y = a[i + 2] * b[j] - a[i] * b[j + 2];
    out[o + 2] = a[i] * b[j + 1] - a[i + 1] * b[j];
    out[o] = x;
    out[o + 1] = y;
  };

  // Rodrigues' formula about a unit axis.
  const about = (axis, i, angle, out) => {
    const x = axis[i], y = axis[i + 1], z = axis[i + 2], s = Math.sin(angle), c = Math.cos(angle), t = 1 - c;
    out.set([c + t * x * x, t * x * y - s * z, t * x * z + s * y, t * x * y + s * z, c + t * y * y, t * y * z - s * x,
      t * x * z - s * y, t * y * z + s * x, c + t * z * z]);
  };

  const IDENTITY = Float64Array.of(1, 0, 0, 0, 1, 0, 0, 0, 1);

  class MassMatrix {
    // `links`: parent, rotation, translation, axis, prismatic, mass, com, inertia, coordinate, ratio, offset by joint,
    // those that mimic others included; armature by coordinate.
    constructor(links) {
      for (const name of ["rotation", "translation", "axis", "mass", "com", "inertia", "ratio", "offset", "armature"]) {
        this[name] = Float64Array.from(links[name]);
      }
      Object.assign(this, { parent: links.parent, prismatic: links.prismatic, coordinate: links.coordinate });
      this.n = links.parent.length;
      this.nv = links.armature.length;
      const n = this.n;
      Object.assign(this, { R: new Float64Array(9 * n), d: new Float64Array(3 * n), a: new Float64Array(3 * n) });
      Object.assign(this, { m: new Float64Array(n), c: new Float64Array(3 * n), B: new Float64Array(9 * n) });
      this.room = new Float64Array(36);
    }

    // Place joint i and its own body; its parent is placed.
    layOut(i, q) {
      const { R, d, a, c, B, room } = this, j = this.parent[i], P = j < 0 ? IDENTITY : R, p = j < 0 ? 0 : 9 * j;
      const A = room.subarray(0, 9), T = room.subarray(9, 18);
      product(P, p, this.rotation, 9 * i, A, 0);
      turn(A, 0, this.axis, 3 * i, a, 3 * i);
      turn(P, p, this.translation, 3 * i, d, 3 * i);
      if (this.prismatic[i]) {
        for (let k = 0; k < 3; k++) d[3 * i + k] += q * a[3 * i + k];
        R.set(A, 9 * i);
      } else {
        about(this.axis, 3 * i, q, T);
        product(A, 0, T, 0, R, 9 * i);
      }
      this.m[i] = this.mass[i];
      turn(R, 9 * i, this.com, 3 * i, c, 3 * i);
      product(R, 9 * i, this.inertia, 9 * i, T, 0);
      for (let x = 0; x < 3; x++) for (let y = 0; y < 3; y++) B[9 * i + 3 * x + y] = dot(T, 3 * x, R, 9 * i + 3 * y);
    }

    // Add all that joint i moves to what its parent moves.
    merge(i) {
      const { m, c, d, B } = this, j = this.parent[i];
      const share = m[i] > 0 ? m[i] / (m[i] + m[j]) : 0, w = share * m[j];  // a mimicking joint may move nothing
      const x = [0, 1, 2].map((k) => d[3 * i + k] + c[3 * i + k] - c[3 * j + k]);
      const square = x[0] * x[0] + x[1] * x[1] + x[2] * x[2];
      m[j] += m[i];
      for (let k = 0; k < 3; k++) {
        c[3 * j + k] += share * x[k];
        for (let l = 0; l < 3; l++) B[9 * j + 3 * k + l] += B[9 * i + 3 * k + l] + w * ((k === l ? square : 0) - x[k] * x[l]);
      }
    }

    // M(q), armature included, symmetric, row by row.
    at(q, out = new Float64Array(this.nv * this.nv)) {
      const { n, nv, parent, prismatic, coordinate, ratio, a, c, d, room } = this;
      const linear = room.subarray(18, 21), moment = room.subarray(21, 24), extra = room.subarray(24, 27);
      out.fill(0);
      for (let i = 0; i < n; i++) this.layOut(i, ratio[i] * q[coordinate[i]] + this.offset[i]);
      for (let i = n - 1; i >= 0; i--) {
        if (parent[i] >= 0) this.merge(i);
        // Momentum of all that joint i moves at unit velocity, and its moment about the joint's origin.
        if (prismatic[i]) linear.set(a.subarray(3 * i, 3 * i + 3));
        else cross(a, 3 * i, c, 3 * i, linear, 0);
        for (let k = 0; k < 3; k++) linear[k] *= this.m[i];
        cross(c, 3 * i, linear, 0, moment, 0);
        if (!prismatic[i]) {
          turn(this.B, 9 * i, a, 3 * i, extra, 0);
          for (let k = 0; k < 3; k++) moment[k] += extra[k];
        }
        for (let k = i; k >= 0; k = parent[k]) {
          // Of two joints with one coordinate both corners of the joints' matrix fall on its diagonal.
          const share = ratio[i] * ratio[k] * dot(a, 3 * k, prismatic[k] ? linear : moment, 0);
          const x = coordinate[i], y = coordinate[k];
          out[x * nv + y] += share;
          if (k !== i) out[y * nv + x] += share;
          cross(d, 3 * k, linear, 0, extra, 0);
          for (let l = 0; l < 3; l++) moment[l] += extra[l];
        }
      }
      for (let i = 0; i < nv; i++) out[i * nv + i] += this.armature[i];
      return out;
    }
  }

  return { MassMatrix };
})();
