// One drawn arm: a chain of scene nodes that joint values move, its colours, and the arcs of its torques.
// Expects MeshCat, inlined above.
"use strict";
const AsmcArm = (() => {
  const THREE = MeshCat.THREE;
  const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  const SEGMENTS = 48, SIDES = 6;
  const LIMIT = "#d4141c";  // of a torque that stands at its limit

  class ArmView {
    // `like`, another view of the same arm, lends its meshes: they are decoded, and lie on the graphics card, once.
    constructor(viewer, name, arm, commands, like = null) {
      this.arm = arm;
      this.root = viewer.scene_tree.find(["replay", name]).object;
      this.motions = [];
      this.drawn = [];  // its mesh, by the number of the body
      const paths = [];
      arm.bodies.forEach((body, index) => {
        const path = index ? paths[body.parent].concat(`joint${index}`) : ["replay", name, "base"];
        viewer.set_transform(path, body.placement);
        paths.push(path.concat("motion"));
        this.motions.push(viewer.scene_tree.find(paths[index]).object);
        if (!commands[index]) return;
        if (like) viewer.set_object(paths[index], like.drawn[index].clone());
        else {
          // Meshcat decodes its own command; only the path is this arm's.
          viewer.prefix = "/" + paths[index].join("/");
          viewer.handle_command_bytearray(bytes(commands[index]));
          viewer.prefix = "";
        }
        // What hangs on it comes later: the one mesh below is its own.
        this.motions[index].traverse((object) => { if (object.isMesh) this.drawn[index] = object; });
      });
      this.meshes = this.drawn.filter((mesh) => mesh);
      for (const mesh of this.meshes) mesh.receiveShadow = false;
      this.own = this.meshes.map((mesh) => mesh.material);
      this.arcs = [];
    }

    set(q) {
      this.arm.bodies.forEach((body, index) => {
        if (body.joint < 0) return;
        const node = this.motions[index];
        const axis = new THREE.Vector3(...body.axis);
        const value = body.ratio * q[body.joint] + body.offset;
        if (body.prismatic) node.position.copy(axis.multiplyScalar(value));
        else node.quaternion.setFromAxisAngle(axis, value);
      });
    }

    // The whole arm in one colour, which `shade` sets.
    makeShaded() {
      this.material = new THREE.MeshPhongMaterial({ shininess: 12, side: THREE.DoubleSide });
      for (const mesh of this.meshes) mesh.material = this.material;
    }

    shade(red, green, blue) { this.material.color.setRGB(red, green, blue); }

    // Where the tip is, in the arm's base frame.
    tip() {
      const point = new THREE.Vector3(...this.arm.tip.point);
      let node = this.motions[this.arm.tip.body];
      for (; node !== this.root; node = node.parent) {
        node.updateMatrix();
        point.applyMatrix4(node.matrix);
      }
      return point;
    }

    // The whole arm translucent in one colour; null gives it back its own.
    tint(colour, opacity) {
      this.meshes.forEach((mesh, k) => {
        mesh.castShadow = colour === null;
        mesh.renderOrder = colour === null ? 0 : 1;
        mesh.material = colour === null ? this.own[k] : this.translucent(colour, opacity);
      });
    }

    // Pushed back a little, so that where a ghost and a solid arm coincide the solid one is seen. Its outside alone:
    // what is translucent and has two sides is drawn twice, and its shaders are looked up anew each time.
    translucent(colour, opacity) {
      this.veil ??= new THREE.MeshPhongMaterial({
        transparent: true, depthWrite: false, side: THREE.FrontSide, polygonOffset: true, polygonOffsetFactor: 2, polygonOffsetUnits: 8,
      });
      this.veil.color.set(colour);
      this.veil.opacity = opacity;
      return this.veil;
    }

    // Arcs about the joints' axes, bars along them where they slide; `show` gives them their length.
    addArcs(colour, radius) {
      const round = Array.from({ length: 33 }, (_, k) => new THREE.Vector3(radius * Math.cos(Math.PI * k / 32), radius * Math.sin(Math.PI * k / 32), 0));
      const straight = [0, 1].map((k) => new THREE.Vector3(radius, 0, 2 * radius * k));
      const tubes = [round, straight].map((points) => new THREE.TubeGeometry(new THREE.CatmullRomCurve3(points), SEGMENTS, 0.1 * radius, SIDES, false));
      this.colour = colour;
      this.arm.bodies.forEach((body, index) => {
        if (body.joint < 0 || this.arcs[body.joint]) return;
        const tube = tubes[body.prismatic ? 1 : 0].clone(), mesh = new THREE.Mesh(tube, new THREE.MeshBasicMaterial({ color: colour, side: THREE.DoubleSide }));
        const turned = new THREE.Group();
        turned.quaternion.setFromUnitVectors(new THREE.Vector3(0, 0, 1), new THREE.Vector3(...body.axis));
        turned.add(mesh);
        if (!body.prismatic) turned.add(this.track(radius));
        this.motions[index].parent.add(turned);
        this.arcs[body.joint] = { mesh, turned, slides: body.prismatic };
      });
    }

    // The circle that an arc goes along, so that a short arc is found.
    track(radius) {
      const points = Array.from({ length: 64 }, (_, k) => new THREE.Vector3(radius * Math.cos(Math.PI * k / 32), radius * Math.sin(Math.PI * k / 32), 0));
      const material = new THREE.LineBasicMaterial({ color: this.colour, transparent: true, opacity: 0.45 });
      return new THREE.LineLoop(new THREE.BufferGeometry().setFromPoints(points), material);
    }

    // Torques over their limits, from −1 to 1.
    showTorques(shares) {
      this.arcs.forEach(({ mesh, slides }, j) => {
        const share = shares[j], limit = Math.abs(share) >= 1;
        mesh.geometry.setDrawRange(0, 6 * SIDES * Math.round(SEGMENTS * Math.min(1, Math.abs(share))));
        mesh.scale.set(1, slides || share >= 0 ? 1 : -1, slides && share < 0 ? -1 : 1);
        mesh.material.color.set(limit ? LIMIT : this.colour);
      });
    }

    showArcs(on, scale) {
      for (const { turned } of this.arcs) {
        turned.visible = on;
        turned.scale.setScalar(scale);
      }
    }
  }

  return { ArmView, bytes };
})();
