// What is seen: one arm per motion on Meshcat's scene, its ghost, the ground, the light and the camera.
// Knows nothing of time; player.js moves it. Expects MeshCat and arm_view.js, inlined above.
"use strict";
const AsmcScene = (() => {
  const THREE = MeshCat.THREE, { ArmView } = AsmcArm;

  // A child element; its text is never read as HTML.
  const element = (parent, tag, attributes = {}, text = "") => {
    const made = document.createElement(tag);
    for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
    made.textContent = text;
    parent.append(made);
    return made;
  };

  const GHOST = 0x5b9bff, GHOSTLY = 0.5, TINTED = 0.55;  // colour of the reference, and how opaque what is translucent is

  // Half the angle that the picture is wide, rad. So long a lens sees all arms from one side, and no outer one leans.
  const LENS = 0.05;

  class Stage {
    constructor(host, data, embedded) {
      this.host = host;
      this.data = data;
      const { low, high } = data.stage;
      this.reach = Math.max(...high.map((value, k) => value - low[k]));
      this.off = data.motions.map(() => false);
      this.parts = { reference: true, paths: true, torques: true };
      this.together = false;  // all arms on one base
      this.openViewer(embedded);
      this.light();
      this.populate();
      this.arrange();
      // Until the user turns the view, it keeps all arms in sight.
      this.viewer.controls.addEventListener("start", () => { this.turned = true; });
      new ResizeObserver(() => {
        if (!this.viewer.set_3d_pane_size() || !host.clientHeight || this.turned) return;
        this.arrange();
        this.resetView();
      }).observe(host);
    }

    openViewer(embedded) {
      const viewer = new MeshCat.Viewer(element(this.host, "div", { class: "replay-pane" }), false);
      this.viewer = viewer;
      viewer.gui.domElement.remove();
      // Meshcat fills the window; here it fills its stage. Sizing empties the canvas: only where the size is another.
      const resize = viewer.set_3d_pane_size.bind(viewer), size = { width: -1, height: -1 };
      viewer.set_3d_pane_size = () => {
        const { clientWidth: width, clientHeight: height } = this.host, other = width !== size.width || height !== size.height;
        if (other) resize(width, height);
        Object.assign(size, { width, height });
        return other;
      };
      window.onload = null;
      viewer.prefix = "";
      const handle = viewer.handle_command.bind(viewer);
      viewer.handle_command = (command) => handle({ ...command, path: viewer.prefix + (command.path || "") });
      viewer.controls.enableZoom = !embedded;
      this.canvas = viewer.renderer.domElement;
      this.canvas.setAttribute("role", "img");
      this.canvas.setAttribute("aria-label", `Three-dimensional view of ${this.data.arm.name}: ${this.data.motions.map(({ label }) => label).join(", ")}`);
      // In a longer page a swipe up or down scrolls the page; sideways it turns the view, two fingers zoom.
      if (embedded) for (const touched of [this.canvas, viewer.controls.domElement]) touched.style.touchAction = "pan-y";
    }

    light() {
      const { viewer } = this;
      for (const name of ["PointLightNegativeX", "PointLightPositiveX", "FillLight", "SpotLight"]) {
        viewer.set_property(["Lights", name], "visible", false);
      }
      viewer.set_property(["Axes"], "visible", false);
      viewer.set_property(["Grid"], "visible", false);
      viewer.scene_tree.find(["Lights", "AmbientLight", "<object>"]).object.intensity = 0.5;
      this.key = new THREE.DirectionalLight(0xffffff, 0.62);
      this.key.castShadow = true;
      this.key.shadow.mapSize.set(2048, 2048);
      this.key.shadow.radius = 4;
      viewer.set_object(["Lights", "Key"], this.key);
      const rim = new THREE.DirectionalLight(0xdfe8ff, 0.38);
      rim.position.set(-2, 1.5, 1.2);
      viewer.set_object(["Lights", "Rim"], rim);
    }

    populate() {
      const { arm, commands, motions, reference, stage } = this.data;
      this.arms = [];
      const view = (name) => new ArmView(this.viewer, name, arm, commands, this.arms[0]);
      motions.forEach((_, k) => this.arms.push(view(`arm${k}`)));
      this.ghosts = reference === null ? [] : motions.map((_, k) => view(`ghost${k}`));
      for (const ghost of this.ghosts) ghost.tint(GHOST, GHOSTLY);
      motions.forEach((motion, k) => {
        if (motion.shades) this.arms[k].makeShaded();
        if (motion.torque) this.arms[k].addArcs(motion.colour, 0.085 * this.reach);
      });
      this.paths = motions.map((motion, k) => this.line(`path${k}`, motion.colour, 1));
      this.wanted = this.ghosts.map((_, k) => this.line(`wanted${k}`, "#7f8894", 0.9));
      const labels = element(this.host, "div", { class: "replay-labels" });
      this.badge = element(this.host, "p", { class: "replay-badge" });
      this.badge.hidden = true;
      this.labels = motions.map((motion) => {
        const label = element(labels, "div", { class: "replay-label" });
        label.style.setProperty("--colour", motion.colour);
        element(label, "b", {}, motion.label);
        return { label, value: element(label, "span") };
      });
      const thick = 0.016 * this.reach;
      this.rim = 1.12 * stage.radius + 1.5 * thick;
      const ring = new THREE.RingGeometry(this.rim - thick, this.rim, 96);
      this.rings = motions.map((motion, k) => this.add(`ring${k}`, new THREE.Mesh(ring, new THREE.MeshBasicMaterial({ color: motion.colour }))));
      this.pedestals = [];
      if (stage.pedestal !== null) {
        const block = new THREE.CylinderGeometry(0.92 * stage.radius, stage.radius, stage.pedestal - stage.ground, 64).rotateX(Math.PI / 2);
        const material = new THREE.MeshPhongMaterial({ color: 0x9aa3ae, shininess: 8 });
        this.pedestals = motions.map((_, k) => this.add(`pedestal${k}`, new THREE.Mesh(block, material)));
        for (const pedestal of this.pedestals) pedestal.castShadow = true;
      }
    }

    add(name, object) {
      this.viewer.set_object(["replay", name], object);
      return object;
    }

    line(name, colour, opacity) {
      const material = new THREE.LineBasicMaterial({ color: colour, transparent: opacity < 1, opacity });
      const line = this.add(name, new THREE.Line(new THREE.BufferGeometry(), material));
      line.frustumCulled = false;
      return line;
    }

    // Arms stand in rows across the line of sight; as many columns as the stage is wide for.
    arrange() {
      const { outline, centre, ground, pedestal, azimuth } = this.data.stage;
      const right = [-Math.sin(azimuth), Math.cos(azimuth)], toward = [Math.cos(azimuth), Math.sin(azimuth)];
      const span = (d) => {
        const along = outline.map((point) => point[0] * d[0] + point[1] * d[1]);
        return Math.max(...along, this.rim) - Math.min(...along, -this.rim);
      };
      const count = this.arms.length;
      const aspect = this.host.clientWidth / Math.max(1, this.host.clientHeight);
      const fit = this.together ? count : Math.min(count, Math.max(1, Math.min(4, Math.round(aspect * 2.2))));
      const rows = Math.ceil(count / fit), columns = Math.ceil(count / rows);
      this.host.style.setProperty("--columns", columns);  // as wide as its arm's place may a label be
      this.elevation = rows > 1 ? 0.5 : 0.3;
      const { low, high } = this.data.stage, tall = high[2] - low[2] + 0.3 * this.reach;  // with the label below
      // A row stands so far in front of the next that it hides nothing of it.
      const across = 1.04 * span(right) + 0.06 * this.reach;
      const deep = Math.max(1.3 * span(toward) + 0.15 * this.reach, tall / Math.tan(this.elevation));
      this.offsets = this.arms.map((_, k) => {
        const row = Math.floor(k / columns), inRow = Math.min(columns, count - row * columns);
        const u = (k % columns - (inRow - 1) / 2) * across, w = (row - (rows - 1) / 2) * deep;
        return this.together ? [0, 0] : [right[0] * u + toward[0] * w, right[1] * u + toward[1] * w];
      });
      const upright = new THREE.Matrix4().fromArray(this.data.arm.upright);
      this.offsets.forEach(([x, y], k) => {
        const pose = new THREE.Matrix4().makeTranslation(x, y, 0).multiply(upright);
        for (const object of [this.arms[k].root, this.ghosts[k]?.root, this.paths[k], this.wanted[k]]) {
          if (object) pose.decompose(object.position, object.quaternion, object.scale);
        }
        this.rings[k].position.set(x + centre[0], y + centre[1], ground + 0.002 * this.reach);
        this.pedestals[k]?.position.set(x + centre[0], y + centre[1], (ground + pedestal) / 2);
      });
      this.floor();
    }

    // Grid, shadows and background, in the page's light or dark colours.
    floor(dark = matchMedia("(prefers-color-scheme: dark)").matches) {
      const { ground } = this.data.stage, { reach, key } = this;
      const decade = 10 ** Math.floor(Math.log10(reach / 12));  // an arm may be in millimetres
      const cell = decade * [1, 2, 5, 10].find((factor) => factor * decade > reach / 12);
      const far = Math.max(...this.offsets.map((o) => Math.hypot(...o)), 0) + 2.2 * reach;
      const cells = 2 * Math.ceil(far / cell);
      this.extent = 4 * far;  // beyond the floor's corners, wherever the view is shifted to
      const grid = new THREE.GridHelper(cells * cell, cells, dark ? 0x4a525d : 0xb7bfc9, dark ? 0x333a43 : 0xcfd5dc);
      grid.rotateX(Math.PI / 2);
      grid.position.z = ground;
      this.viewer.set_object(["Floor", "grid"], grid);
      const plane = new THREE.Mesh(new THREE.PlaneGeometry(cells * cell, cells * cell), new THREE.ShadowMaterial({ opacity: dark ? 0.4 : 0.2 }));
      plane.position.z = ground - 0.001 * reach;
      plane.receiveShadow = true;
      this.viewer.set_object(["Floor", "shadow"], plane);
      const height = far + reach;
      key.position.set(0.9 * height, -0.5 * height, 1.7 * height);
      Object.assign(key.shadow.camera, { left: -far, right: far, top: far, bottom: -far, near: 0.1 * height, far: 5 * height });
      key.shadow.camera.updateProjectionMatrix();
      const shade = (hex) => [16, 8, 0].map((shift) => ((hex >> shift) & 255) / 255);
      this.viewer.set_property(["Background"], "top_color", shade(dark ? 0x23282f : 0xf3f5f8));
      this.viewer.set_property(["Background"], "bottom_color", shade(dark ? 0x171a1f : 0xe3e7ec));
      this.viewer.set_dirty();
    }

    // Paths of the tips. `shown(a)` and `wanted` are lists of joint values; the arms are left at the last of them.
    // `shades[a]` has the path's colour at each of them, or is null.
    trace(shown, wanted, shades) {
      const path = (arm, frames) => frames.map((q) => { arm.set(q); return arm.tip(); });
      const put = (line, points) => {
        line.geometry.dispose();
        line.geometry = new THREE.BufferGeometry().setFromPoints(points);
      };
      this.paths.forEach((line, a) => {
        put(line, path(this.arms[a], shown(a)));
        if (!shades[a]) return;
        line.geometry.setAttribute("color", new THREE.BufferAttribute(shades[a], 3));
        line.material.color.set("#ffffff");
        line.material.vertexColors = true;
      });
      if (this.ghosts.length) {
        const points = path(this.ghosts[0], wanted);
        for (const line of this.wanted) put(line, points);
      }
    }

    // All arms on one base, tinted, with the reference as the solid one; or side by side with a ghost of it in each.
    gather(together) {
      this.together = together;
      this.arms.forEach((arm, k) => arm.tint(together ? this.data.motions[k].colour : null, TINTED));
      this.ghosts[0]?.tint(together ? null : GHOST, GHOSTLY);
      this.host.classList.toggle("is-together", together);
      for (const { label } of this.labels) label.style.transform = "";
      this.arrange();
      this.show({});
      this.resetView();
    }

    // Says in the picture that errors are magnified.
    magnified(factor) {
      this.badge.textContent = `Errors ×${factor}`;
      this.badge.hidden = factor === 1;
    }

    // What is to be seen of every motion that is not hidden itself.
    show(parts) {
      Object.assign(this.parts, parts);
      const { reference, paths, torques } = this.parts, { together } = this;
      this.arms.forEach((arm, k) => {
        const on = !this.off[k], set = (object, seen) => { if (object) object.visible = seen; };
        set(arm.root, on);
        // On one base there is one ring, one pedestal and one reference, whoever is hidden.
        for (const object of [this.rings[k], this.pedestals[k]]) set(object, together ? k === 0 : on);
        for (const object of [this.ghosts[k]?.root, this.wanted[k]]) set(object, reference && (together ? k === 0 : on));
        this.rings[k].material.color.set(together ? GHOST : this.data.motions[k].colour);
        set(this.paths[k], on && paths);
        arm.showArcs(torques, together ? 1 + 0.22 * k : 1);  // one outside the other
      });
      this.viewer.set_dirty();
    }

    hide(label, off) {
      this.data.motions.forEach((motion, k) => { if (motion.label === label) this.off[k] = off; });
      this.show({});
    }

    // The camera around what it looks at, in steps: rad around and up, and a factor of the distance.
    turn(around, up, factor) {
      const { viewer } = this, { target } = viewer.controls;
      const seen = new THREE.Spherical().setFromVector3(viewer.camera.position.clone().sub(target));
      seen.theta += around;
      seen.phi = Math.min(Math.max(seen.phi - up, 0.05), Math.PI - 0.05);
      seen.radius *= factor;
      viewer.camera.position.setFromSpherical(seen).add(target);
      viewer.controls.update();
      this.turned = true;
      viewer.set_dirty();
    }

    // The nearest camera on the line of sight that sees all arms and their labels.
    resetView() {
      const { viewer, elevation, rim } = this, { outline, centre, ground, azimuth } = this.data.stage;
      this.turned = false;
      viewer.set_3d_pane_size();
      viewer.camera.fov = THREE.MathUtils.radToDeg(2 * Math.atan(Math.tan(LENS) / Math.max(1, viewer.camera.aspect)));
      const toward = new THREE.Vector3(Math.cos(azimuth) * Math.cos(elevation), Math.sin(azimuth) * Math.cos(elevation), Math.sin(elevation));
      const right = new THREE.Vector3(-Math.sin(azimuth), Math.cos(azimuth), 0);
      const up = new THREE.Vector3().crossVectors(toward, right);
      const around = [0, 1, 2, 3, 4, 5, 6, 7].map((k) => k * Math.PI / 4);
      const base = around.map((angle) => [centre[0] + rim * Math.cos(angle), centre[1] + rim * Math.sin(angle), ground]);
      const points = this.offsets.flatMap((o) => [...outline, ...base].map((p) => new THREE.Vector3(p[0] + o[0], p[1] + o[1], p[2])));
      const middle = new THREE.Box3().setFromPoints(points).getCenter(new THREE.Vector3());
      const seen = points.map((point) => {
        const p = point.sub(middle);
        return { depth: p.dot(toward), x: p.dot(right), y: p.dot(up) };
      });
      // Tangents of the free angles: a rim all round, and room below for the labels.
      const tall = Math.tan(THREE.MathUtils.degToRad(viewer.camera.fov / 2));
      const above = tall * (1 - 2 * 14 / this.host.clientHeight), below = tall * (1 - 2 * 62 / this.host.clientHeight);
      const beside = 0.95 * tall * viewer.camera.aspect;
      // At a target x to the side, left and right need these distances; both are least where they are equal. So too for y.
      const need = (value, tangent) => Math.max(...seen.map((p) => p.depth + value(p) / tangent));
      const x = (need((p) => p.x, beside) - need((p) => -p.x, beside)) * beside / 2;
      const y = (need((p) => p.y, above) - need((p) => -p.y, below)) * above * below / (above + below);
      const distance = Math.max(need((p) => Math.abs(p.x - x), beside), need((p) => p.y - y, above), need((p) => y - p.y, below));
      middle.addScaledVector(right, x).addScaledVector(up, y);
      // Meshcat's camera lives in three.js axes: y up.
      const swap = (v) => new THREE.Vector3(v.x, v.z, -v.y);
      viewer.controls.target.copy(swap(middle));
      viewer.camera.position.copy(swap(middle.clone().addScaledVector(toward, distance)));
      viewer.controls.update();
      viewer.set_dirty();
    }

    // What the scene shows now, as a picture in the page: paper has no canvas.
    still(title) {
      const { host } = this;
      if (!host.clientWidth || !host.clientHeight) return;  // hidden: the former still stays
      const image = host.parentElement.querySelector(".replay-still") ?? element(host.parentElement, "img", { class: "replay-still" });
      image.src = this.photograph().toDataURL("image/jpeg", 0.9);
      image.alt = `${title}: ${this.labels.map(({ label }) => label.innerText.replace("\n", " ")).join("; ")}`;
    }

    // The picture with its labels, as paper needs it: a canvas of its own.
    photograph() {
      const { viewer, canvas, host } = this, made = document.createElement("canvas"), pen = made.getContext("2d");
      this.floor(false);
      this.draw();  // in the same turn, or the browser may have emptied the canvas
      Object.assign(made, { width: canvas.width, height: canvas.height });
      pen.drawImage(canvas, 0, 0);
      this.floor();
      pen.scale(canvas.width / host.clientWidth, canvas.height / host.clientHeight);
      const { left, top } = host.getBoundingClientRect();
      for (const box of host.querySelectorAll(".replay-label, .replay-badge")) {
        if (box.hidden || !box.offsetWidth) continue;
        const at = box.getBoundingClientRect(), x = at.left - left, y = at.top - top;
        pen.fillStyle = "rgb(255 255 255 / .86)";
        pen.fillRect(x, y, at.width, at.height);
        pen.fillStyle = box.style.getPropertyValue("--colour") || "#1d2430";
        pen.fillRect(x, y, at.width, 3);
        Object.assign(pen, { fillStyle: "#1d2430", textAlign: "center", textBaseline: "middle" });
        const lines = [...(box.children.length ? box.children : [box])].filter((line) => line.textContent);
        for (const line of lines) {
          const own = line.getBoundingClientRect(), { fontWeight, fontSize, fontFamily } = getComputedStyle(line);
          pen.font = `${fontWeight} ${fontSize} ${fontFamily}`;
          pen.fillText(line.textContent, x + at.width / 2, own.top - top + own.height / 2, at.width - 8);
        }
      }
      return made;
    }

    // Beyond the window's edge a motion goes on unseen, and is drawn when it is seen again.
    get seen() {
      const { top, bottom } = this.host.getBoundingClientRect();
      return bottom > 0 && top < innerHeight;
    }

    render() {
      if (!this.viewer.needs_render || (this.drawn && !this.seen)) return;
      this.draw();
    }

    draw() {
      const { viewer, extent } = this, { camera, controls } = viewer, away = camera.position.distanceTo(controls.target);
      // As near to what is seen as may be: depths are told apart by their ratio, and a long lens stands far off.
      Object.assign(camera, { near: Math.max(away - extent, away / 200), far: away + extent });
      this.drawn = true;
      viewer.render();
      this.placeLabels();
    }

    placeLabels() {
      const { host, labels, off, rim } = this, { centre, ground } = this.data.stage, { camera } = this.viewer;
      if (this.together) {  // in a row below, as the style sheet has them
        labels.forEach(({ label }, k) => { label.hidden = off[k]; });
        return;
      }
      const { clientWidth, clientHeight } = host;
      // All widths are asked for before any label moves: a browser lays the page out once.
      const widths = labels.map(({ label }) => label.offsetWidth);
      labels.forEach(({ label }, k) => {
        // In front of the ring, as the camera stands.
        const x = this.offsets[k][0] + centre[0], y = this.offsets[k][1] + centre[1];
        const dx = camera.position.x - x, dy = -camera.position.z - y, step = rim / (Math.hypot(dx, dy) || 1);
        const point = new THREE.Vector3(x + step * dx, ground, -(y + step * dy)).project(camera);
        label.hidden = point.z > 1 || off[k];
        const half = widths[k] / 2 + 4;
        const left = Math.min(Math.max((point.x + 1) / 2 * clientWidth, half), clientWidth - half);
        label.style.transform = `translate(-50%, 5px) translate(${left.toFixed(1)}px, ${((1 - point.y) / 2 * clientHeight).toFixed(1)}px)`;
      });
    }
  }

  return { Stage, element };
})();
