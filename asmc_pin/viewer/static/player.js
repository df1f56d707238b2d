// Plays joint motions on Meshcat's scene: one arm per controller, its reference as a translucent ghost.
// It expects MeshCat (inlined above) and, in each .replay element, the description that motion.py writes.
"use strict";
(() => {
  const THREE = MeshCat.THREE;
  const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  const floats = (text) => new Float32Array(bytes(text).buffer);
  const element = (parent, tag, attributes = {}, text = "") => {
    const made = document.createElement(tag);
    for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
    made.textContent = text;
    parent.append(made);
    return made;
  };
  const svg = (parent, tag, attributes) => {
    const made = document.createElementNS("http://www.w3.org/2000/svg", tag);
    for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
    parent.append(made);
    return made;
  };

  // One drawn arm: a chain of scene nodes, moved by joint values.
  class ArmView {
    constructor(viewer, name, arm, commands) {
      this.arm = arm;
      this.root = viewer.scene_tree.find(["replay", name]).object;
      this.motions = [];
      const paths = [];
      arm.bodies.forEach((body, index) => {
        const path = (index ? paths[body.parent].concat(`joint${index}`) : ["replay", name, "base"]);
        viewer.set_transform(path, body.placement);
        paths.push(path.concat("motion"));
        this.motions.push(viewer.scene_tree.find(paths[index]).object);
        if (commands[index]) {
          // Meshcat decodes its own command; only the path is this arm's.
          viewer.prefix = "/" + paths[index].join("/");
          viewer.handle_command_bytearray(bytes(commands[index]));
          viewer.prefix = "";
        }
      });
      this.meshes = [];
      this.root.traverse((object) => { if (object.isMesh) this.meshes.push(object); });
      for (const mesh of this.meshes) mesh.receiveShadow = false;
    }

    set(q) {
      this.arm.bodies.forEach((body, index) => {
        if (body.joint < 0) return;
        const node = this.motions[index];
        const axis = new THREE.Vector3(...body.axis);
        if (body.prismatic) node.position.copy(axis.multiplyScalar(q[body.joint]));
        else node.quaternion.setFromAxisAngle(axis, q[body.joint]);
      });
    }

    tip() {
      const point = new THREE.Vector3(...this.arm.tip.point);
      let node = this.motions[this.arm.tip.body];
      for (; node !== this.root; node = node.parent) {
        node.updateMatrix();
        point.applyMatrix4(node.matrix);
      }
      return point;
    }

    paint(colour, opacity) {
      for (const mesh of this.meshes) {
        mesh.castShadow = false;
        mesh.renderOrder = 1;
        // Pushed back a little, so that where ghost and arm coincide the arm is seen.
        mesh.material = new THREE.MeshPhongMaterial({
          color: colour, transparent: true, opacity, depthWrite: false, side: THREE.DoubleSide,
          polygonOffset: true, polygonOffsetFactor: 2, polygonOffsetUnits: 8,
        });
      }
    }
  }

  class Replay {
    constructor(host) {
      this.host = host;
      this.data = JSON.parse(host.querySelector("script[type='application/json']").textContent);
      this.time = 0;
      this.playing = false;
      this.speed = 1;
      this.magnify = 1;
      this.stage = host.querySelector(".replay-stage");
      this.embedded = host.dataset.embedded === "true";
      this.decode();
      this.openViewer();
      this.light();
      this.populate();
      this.arrange();
      this.buildControls();
      this.listen();
      this.seek(0);
      this.resetView();
      this.start();
    }

    decode() {
      const { joints, motions, reference } = this.data;
      this.nv = joints.length;
      this.q = motions.map((motion) => floats(motion.q));
      this.reference = reference === null ? null : floats(reference);
      this.count = this.q.length ? this.q[0].length / this.nv : 1;
      this.duration = this.data.duration;
      this.errors = this.reference ? this.q.map((q) => this.largestError(q)) : [];
    }

    // Largest joint error of every frame, in degrees, or in millimetres on an arm that only slides.
    largestError(q) {
      const turning = this.data.joints.some((joint) => !joint.prismatic);
      return Float64Array.from({ length: this.count }, (_, k) => {
        let largest = 0;
        this.data.joints.forEach((joint, j) => {
          if (joint.prismatic === turning) return;
          const error = Math.abs(q[k * this.nv + j] - this.reference[k * this.nv + j]);
          largest = Math.max(largest, error * (turning ? 180 / Math.PI : 1000));
        });
        return largest;
      });
    }

    unit() { return this.data.joints.some((joint) => !joint.prismatic) ? "°" : " mm"; }

    openViewer() {
      const viewer = new MeshCat.Viewer(element(this.stage, "div", { class: "replay-pane" }), false);
      this.viewer = viewer;
      viewer.gui.domElement.remove();
      // Meshcat fills the window; here it fills its stage.
      const resize = viewer.set_3d_pane_size.bind(viewer);
      viewer.set_3d_pane_size = () => resize(this.stage.clientWidth, this.stage.clientHeight);
      window.onload = null;
      viewer.prefix = "";
      const handle = viewer.handle_command.bind(viewer);
      viewer.handle_command = (command) => handle({ ...command, path: viewer.prefix + (command.path || "") });
      const render = viewer.render.bind(viewer);
      viewer.render = () => { render(); this.placeLabels(); };
      viewer.camera.fov = 32;
      viewer.controls.enableZoom = !this.embedded;
      viewer.renderer.domElement.setAttribute("aria-label", "Three-dimensional view of the arms");
      this.canvas = viewer.renderer.domElement;
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
      const { arm, commands, motions } = this.data;
      this.arms = motions.map((_, k) => new ArmView(this.viewer, `arm${k}`, arm, commands));
      this.ghosts = this.reference
        ? motions.map((_, k) => {
          const ghost = new ArmView(this.viewer, `ghost${k}`, arm, commands);
          ghost.paint(0x5b9bff, 0.34);
          return ghost;
        })
        : [];
      this.paths = motions.map((motion) => this.line(motion.colour, 1));
      this.wanted = this.reference ? motions.map(() => this.line("#7f8894", 0.9)) : [];
      const labels = element(this.stage, "div", { class: "replay-labels" });
      this.labels = motions.map((motion) => {
        const label = element(labels, "div", { class: "replay-label" });
        label.style.setProperty("--colour", motion.colour);
        element(label, "b", {}, motion.label);
        return { label, value: element(label, "span") };
      });
      const around = this.data.stage, thick = 0.016 * this.reach();
      this.rings = motions.map((motion, k) => {
        const inner = 1.12 * around.radius + 0.5 * thick;
        const ring = new THREE.Mesh(new THREE.RingGeometry(inner, inner + thick, 96), new THREE.MeshBasicMaterial({ color: motion.colour }));
        this.viewer.set_object(["replay", `ring${k}`], ring);
        return ring;
      });
      this.pedestals = around.pedestal === null ? [] : motions.map((_, k) => {
        const height = around.pedestal - around.ground;
        const shape = new THREE.CylinderGeometry(0.92 * around.radius, around.radius, height, 64);
        const pedestal = new THREE.Mesh(shape.rotateX(Math.PI / 2), new THREE.MeshPhongMaterial({ color: 0x9aa3ae, shininess: 8 }));
        pedestal.castShadow = true;
        this.viewer.set_object(["replay", `pedestal${k}`], pedestal);
        return pedestal;
      });
    }

    line(colour, opacity) {
      const line = new THREE.Line(
        new THREE.BufferGeometry(),
        new THREE.LineBasicMaterial({ color: colour, transparent: opacity < 1, opacity }),
      );
      line.frustumCulled = false;
      this.viewer.set_object(["replay", `line${this.lines = (this.lines || 0) + 1}`], line);
      return line;
    }

    // Arms stand in rows across the line of sight; as many columns as the stage is wide for.
    arrange() {
      const { low, high, outline, centre, ground, pedestal } = this.data.stage;
      const size = high.map((value, k) => value - low[k]);
      const flat = size[1] < 0.4 * size[0];
      this.azimuth = flat ? -Math.PI / 2 + 0.28 : (size[0] < 0.4 * size[1] ? 0.28 : -0.62);
      const right = [-Math.sin(this.azimuth), Math.cos(this.azimuth)];
      const toward = [Math.cos(this.azimuth), Math.sin(this.azimuth)];
      const span = (d) => {
        const along = outline.map((point) => point[0] * d[0] + point[1] * d[1]);
        return Math.max(...along) - Math.min(...along);
      };
      const count = this.arms.length;
      const aspect = this.stage.clientWidth / Math.max(1, this.stage.clientHeight);
      const fit = Math.min(count, Math.max(1, Math.min(4, Math.round(aspect * 2.2))));
      const columns = Math.ceil(count / Math.ceil(count / fit));
      const across = 1.04 * span(right) + 0.06 * this.reach(), deep = 1.3 * span(toward) + 0.15 * this.reach();
      const rows = Math.ceil(count / columns);
      this.elevation = rows > 1 ? 0.5 : 0.3;
      this.offsets = this.arms.map((_, k) => {
        const row = Math.floor(k / columns);
        const inRow = Math.min(columns, count - row * columns);
        const u = (k % columns - (inRow - 1) / 2) * across, w = ((rows - 1) / 2 - row) * -deep;
        return [right[0] * u + toward[0] * w, right[1] * u + toward[1] * w];
      });
      const place = (object, k, z = 0) => {
        const upright = new THREE.Matrix4().fromArray(this.data.arm.upright);
        new THREE.Matrix4().makeTranslation(...this.offsets[k], z).multiply(upright)
          .decompose(object.position, object.quaternion, object.scale);
      };
      this.arms.forEach((arm, k) => place(arm.root, k));
      this.ghosts.forEach((ghost, k) => place(ghost.root, k));
      this.paths.forEach((line, k) => place(line, k));
      this.wanted.forEach((line, k) => place(line, k));
      this.rings.forEach((ring, k) => {
        ring.position.set(this.offsets[k][0] + centre[0], this.offsets[k][1] + centre[1], ground + 0.002 * this.reach());
      });
      this.pedestals.forEach((block, k) => {
        block.position.set(this.offsets[k][0] + centre[0], this.offsets[k][1] + centre[1], (ground + pedestal) / 2);
      });
      this.floor();
      this.trace();
    }

    reach() {
      const { low, high } = this.data.stage;
      return Math.max(...high.map((value, k) => value - low[k]));
    }

    floor() {
      const { ground } = this.data.stage, reach = this.reach();
      const cell = [0.02, 0.05, 0.1, 0.25, 0.5, 1].find((c) => c > reach / 12) || 1;
      const far = Math.max(...this.offsets.map((o) => Math.hypot(...o)), 0) + 2.2 * reach;
      const cells = 2 * Math.ceil(far / cell);
      this.cell = cell;
      const dark = document.documentElement.dataset.dark === "true";
      const grid = new THREE.GridHelper(cells * cell, cells, dark ? 0x4a525d : 0xb7bfc9, dark ? 0x333a43 : 0xcfd5dc);
      grid.rotateX(Math.PI / 2);
      grid.position.z = ground;
      this.viewer.set_object(["Floor", "grid"], grid);
      const plane = new THREE.Mesh(new THREE.PlaneGeometry(cells * cell, cells * cell), new THREE.ShadowMaterial({ opacity: dark ? 0.4 : 0.2 }));
      plane.position.z = ground - 0.001 * reach;
      plane.receiveShadow = true;
      this.viewer.set_object(["Floor", "shadow"], plane);
      const near = far + reach;
      this.key.position.set(0.9 * near, -0.5 * near, 1.7 * near);
      Object.assign(this.key.shadow.camera, { left: -far, right: far, top: far, bottom: -far, near: 0.1 * near, far: 5 * near });
      this.key.shadow.camera.updateProjectionMatrix();
      const shade = (hex) => [16, 8, 0].map((shift) => ((hex >> shift) & 255) / 255);
      this.viewer.set_property(["Background"], "top_color", shade(dark ? 0x23282f : 0xf3f5f8));
      this.viewer.set_property(["Background"], "bottom_color", shade(dark ? 0x171a1f : 0xe3e7ec));
    }

    // Paths of the tips over the whole motion; differences from the reference magnified as the arms show them.
    trace() {
      const path = (arm, values) => {
        const points = [];
        for (let k = 0; k < this.count; k += 1) {
          arm.set(values(k));
          points.push(arm.tip());
        }
        return points;
      };
      this.paths.forEach((line, a) => {
        line.geometry.dispose();
        const frames = this.lastFrame(a);
        line.geometry = new THREE.BufferGeometry().setFromPoints(path(this.arms[a], (k) => this.shown(a, Math.min(k, frames))));
      });
      if (!this.wanted.length) return;
      const points = path(this.ghosts[0], (k) => this.reference.subarray(k * this.nv, (k + 1) * this.nv));
      for (const line of this.wanted) {
        line.geometry.dispose();
        line.geometry = new THREE.BufferGeometry().setFromPoints(points);
      }
    }

    lastFrame(a) {
      const { end } = this.data.motions[a];
      return end === null ? this.count - 1 : Math.floor(end / this.step());
    }

    step() { return this.count > 1 ? this.duration / (this.count - 1) : 1; }

    // Joint values between two frames.
    between(values, frame) {
      const k = Math.min(Math.floor(frame), this.count - 1), next = Math.min(k + 1, this.count - 1), w = frame - k;
      return Array.from({ length: this.nv }, (_, j) => (1 - w) * values[k * this.nv + j] + w * values[next * this.nv + j]);
    }

    shown(a, frame) {
      const q = this.between(this.q[a], frame);
      if (this.magnify === 1 || !this.reference) return q;
      const wanted = this.between(this.reference, frame);
      return q.map((value, j) => wanted[j] + this.magnify * (value - wanted[j]));
    }

    seek(time) {
      this.time = Math.min(Math.max(time, 0), this.duration);
      const frame = this.time / this.step();
      this.arms.forEach((arm, a) => {
        arm.set(this.shown(a, Math.min(frame, this.lastFrame(a))));
        this.describe(a, frame);
      });
      if (this.reference) {
        const wanted = this.between(this.reference, frame);
        for (const ghost of this.ghosts) ghost.set(wanted);
      }
      if (this.slider) {
        this.slider.value = this.time;
        this.slider.setAttribute("aria-valuetext", `${this.time.toFixed(2)} seconds`);
        this.clock.textContent = `${this.time.toFixed(2)} s / ${this.duration.toFixed(2)} s`;
        if (this.cursor) this.cursor.setAttribute("transform", `translate(${1000 * this.time / (this.duration || 1)} 0)`);
      }
      this.viewer.set_dirty();
    }

    describe(a, frame) {
      const { label, value } = this.labels[a];
      const { end } = this.data.motions[a];
      const over = end !== null && frame > this.lastFrame(a);
      label.classList.toggle("is-over", over);
      if (over) value.textContent = `diverged at ${end.toFixed(2)} s`;
      else if (this.errors.length) value.textContent = this.format(this.errors[a][Math.round(Math.min(frame, this.count - 1))]);
    }

    format(error) {
      const digits = error >= 100 ? 0 : error >= 10 ? 1 : error >= 1 ? 2 : 3;
      return `${error.toFixed(digits)}${this.unit()}`;
    }

    play() {
      if (this.time >= this.duration) this.seek(0);
      this.playing = this.duration > 0;
      this.last = null;
      this.showState();
    }

    pause() {
      this.playing = false;
      this.showState();
    }

    showState() {
      this.button.setAttribute("aria-label", this.playing ? "Pause" : "Play");
      this.button.title = this.playing ? "Pause (space)" : "Play (space)";
      this.host.classList.toggle("is-playing", this.playing);
    }

    start() {
      const tick = (now) => {
        requestAnimationFrame(tick);
        if (this.playing) {
          const passed = this.last === null ? 0 : (now - this.last) / 1000;
          this.last = now;
          this.seek(this.time + passed * this.speed);
          if (this.time >= this.duration) {
            if (this.loop.checked) this.seek(0);
            else this.pause();
          }
        }
        if (this.viewer.needs_render) this.viewer.render();
      };
      requestAnimationFrame(tick);
      // #t=2.5 opens the page at that time.
      const wish = /^#t=([0-9.]+)$/.exec(location.hash);
      if (wish && !this.embedded) this.seek(Number(wish[1]));
      else if (!this.embedded && !matchMedia("(prefers-reduced-motion: reduce)").matches) this.play();
    }

    buildControls() {
      const bar = element(this.host, "div", { class: "replay-controls" });
      this.button = element(bar, "button", { type: "button", class: "replay-play" });
      const icon = svg(this.button, "svg", { viewBox: "0 0 24 24", "aria-hidden": "true" });
      svg(icon, "path", { class: "icon-play", d: "M7 4.5v15l13-7.5z" });
      svg(icon, "path", { class: "icon-pause", d: "M6 4.5h4.2v15H6zM13.8 4.5H18v15h-4.2z" });
      this.clock = element(bar, "output", { class: "replay-clock" });
      const track = element(bar, "div", { class: "replay-track" });
      if (this.errors.length && this.count > 1) this.chart(track);
      this.slider = element(track, "input", {
        type: "range", min: 0, max: this.duration, step: "any", value: 0, "aria-label": "Time",
      });
      const choice = (text, options, act) => {
        const label = element(bar, "label", {}, text);
        const select = element(label, "select");
        for (const [value, name] of options) element(select, "option", { value }, name);
        select.addEventListener("change", () => act(Number(select.value)));
        return select;
      };
      const box = (text, checked, act) => {
        const label = element(bar, "label");
        const input = element(label, "input", { type: "checkbox" });
        input.checked = checked;
        label.append(text);
        input.addEventListener("change", () => act(input.checked));
        return input;
      };
      const dirty = () => this.viewer.set_dirty();
      const speed = choice("Speed", [0.1, 0.25, 0.5, 1, 2, 4].map((s) => [s, `${s}×`]), (s) => { this.speed = s; });
      speed.value = "1";
      if (this.reference) {
        this.magnifier = choice("Errors", [1, 5, 20, 100].map((m) => [m, `${m}×`]), (m) => {
          this.magnify = m;
          this.trace();
          this.seek(this.time);
        });
        this.magnifier.parentElement.title = "Magnifies the arms' differences from the reference";
        box("Reference", true, (on) => { for (const g of [...this.ghosts.map((x) => x.root), ...this.wanted]) g.visible = on; dirty(); });
      }
      box("Path", true, (on) => { for (const line of this.paths) line.visible = on; dirty(); });
      this.loop = box("Loop", !this.embedded, () => {});
      const view = element(bar, "button", { type: "button", class: "replay-view" }, "Reset view");
      view.addEventListener("click", () => this.resetView());
      this.showState();
    }

    // The largest joint error over time, above the slider, so that the time of trouble can be found.
    chart(track) {
      const top = Math.max(...this.errors.map((e, a) => e.slice(0, this.lastFrame(a) + 1).reduce((x, y) => Math.max(x, y), 0)), 1e-12);
      element(track, "div", { class: "replay-top" }, `Largest joint error over time, at most ${this.format(top)}`);
      const chart = svg(track, "svg", { viewBox: "0 0 1000 100", preserveAspectRatio: "none", class: "replay-chart", "aria-hidden": "true" });
      this.errors.forEach((errors, a) => {
        const points = Array.from(errors.slice(0, this.lastFrame(a) + 1), (e, k) => `${(1000 * k / (this.count - 1)).toFixed(1)},${(97 - 92 * e / top).toFixed(1)}`);
        svg(chart, "polyline", { points: points.join(" "), style: `stroke:${this.data.motions[a].colour}` });
      });
      this.cursor = svg(chart, "line", { x1: 0, x2: 0, y1: 0, y2: 100 });
      const jump = (event) => {
        const { left, width } = chart.getBoundingClientRect();
        this.seek(this.duration * (event.clientX - left) / width);
      };
      chart.addEventListener("pointerdown", (event) => { this.pause(); chart.setPointerCapture(event.pointerId); jump(event); });
      chart.addEventListener("pointermove", (event) => { if (event.buttons) jump(event); });
    }

    listen() {
      this.button.addEventListener("click", () => (this.playing ? this.pause() : this.play()));
      this.slider.addEventListener("input", () => { this.pause(); this.seek(Number(this.slider.value)); });
      const keys = (event) => {
        if (event.ctrlKey || event.metaKey || event.altKey) return;
        const own = event.target.closest("input, select, button");
        if (event.key === " " && !(own && own.matches("select, button, [type=checkbox]"))) this.playing ? this.pause() : this.play();
        else if (!own && event.key === "ArrowRight") { this.pause(); this.seek(this.time + this.step()); }
        else if (!own && event.key === "ArrowLeft") { this.pause(); this.seek(this.time - this.step()); }
        else if (!own && event.key === "Home") this.seek(0);
        else return;
        event.preventDefault();
      };
      // In a report, space scrolls the page unless the replay has the focus.
      (this.embedded ? this.host : document).addEventListener("keydown", keys);
      if (this.embedded) {
        this.host.tabIndex = 0;
        this.stage.addEventListener("pointerdown", () => { this.host.focus({ preventScroll: true }); this.viewer.controls.enableZoom = true; });
        this.host.addEventListener("focusout", () => { this.viewer.controls.enableZoom = false; });
      }
      // Until the user turns the view, it keeps all arms in sight.
      this.viewer.controls.addEventListener("start", () => { this.turned = true; });
      new ResizeObserver(() => {
        this.viewer.set_3d_pane_size();
        if (!this.stage.clientHeight || this.turned) return;
        this.arrange();
        this.seek(this.time);
        this.resetView();
      }).observe(this.stage);
    }

    // The nearest camera on the line of sight that sees all arms.
    resetView() {
      const { viewer } = this;
      this.turned = false;
      viewer.set_3d_pane_size();
      const { outline, centre, radius, ground } = this.data.stage;
      const { elevation } = this;
      const toward = new THREE.Vector3(Math.cos(this.azimuth) * Math.cos(elevation), Math.sin(this.azimuth) * Math.cos(elevation), Math.sin(elevation));
      const right = new THREE.Vector3(-Math.sin(this.azimuth), Math.cos(this.azimuth), 0);
      const up = new THREE.Vector3().crossVectors(toward, right);
      const tall = Math.tan(THREE.MathUtils.degToRad(viewer.camera.fov / 2)), wide = tall * viewer.camera.aspect;
      const base = [0, 1, 2, 3].map((k) => [centre[0] + 1.2 * radius * Math.cos(k * Math.PI / 2), centre[1] + 1.2 * radius * Math.sin(k * Math.PI / 2), ground]);
      const points = this.offsets.flatMap((o) => [...outline, ...base].map((p) => new THREE.Vector3(p[0] + o[0], p[1] + o[1], p[2])));
      const middle = new THREE.Box3().setFromPoints(points).getCenter(new THREE.Vector3());
      // Room below for the labels, and a rim all round.
      const { clientHeight } = this.stage;
      const above = tall * (1 - 24 / clientHeight), below = tall * (1 - 2 * 62 / clientHeight), beside = wide * 0.94;
      const seen = points.map((point) => {
        const p = point.clone().sub(middle);
        return { depth: p.dot(toward), x: p.dot(right), y: p.dot(up) };
      });
      // Sideways and up, the target that lets the camera come nearest; a few steps settle it.
      let distance = 0, x = 0, y = 0;
      for (let step = 0; step < 12; step += 1) {
        const need = (value, limit) => Math.max(...seen.map((p) => p.depth + value(p) / limit));
        const [l, r, u, d] = [need((p) => x - p.x, beside), need((p) => p.x - x, beside), need((p) => p.y - y, above), need((p) => y - p.y, below)];
        distance = Math.max(l, r, u, d);
        x += (r - l) * beside / 2;
        y += (u - d) * above * below / (above + below);
      }
      middle.addScaledVector(right, x).addScaledVector(up, y);
      // Meshcat's camera lives in three.js axes: y up.
      const swap = (v) => new THREE.Vector3(v.x, v.z, -v.y);
      Object.assign(viewer.camera, { near: distance / 200, far: 40 * distance });
      viewer.camera.updateProjectionMatrix();
      viewer.controls.target.copy(swap(middle));
      viewer.camera.position.copy(swap(middle.clone().addScaledVector(toward, distance)));
      viewer.controls.update();
      viewer.set_dirty();
    }

    placeLabels() {
      const { clientWidth, clientHeight } = this.stage, { centre, radius, ground } = this.data.stage;
      this.labels.forEach(({ label }, k) => {
        // In front of the ring, as the camera stands.
        const eye = this.viewer.camera.position, x = this.offsets[k][0] + centre[0], y = this.offsets[k][1] + centre[1];
        const away = Math.hypot(eye.x - x, -eye.z - y) || 1, step = 1.3 * radius / away;
        const point = new THREE.Vector3(x + step * (eye.x - x), ground, -(y + step * (-eye.z - y))).project(this.viewer.camera);
        label.hidden = point.z > 1;
        const half = label.offsetWidth / 2 + 4;
        const left = Math.min(Math.max((point.x + 1) / 2 * clientWidth, half), clientWidth - half);
        label.style.transform = `translate(-50%, 6px) translate(${left.toFixed(1)}px, ${((1 - point.y) / 2 * clientHeight).toFixed(1)}px)`;
      });
    }
  }

  const theme = matchMedia("(prefers-color-scheme: dark)");
  document.documentElement.dataset.dark = theme.matches;
  window.replays = [];
  for (const host of document.querySelectorAll(".replay")) {
    try {
      window.replays.push(new Replay(host));
    } catch (error) {
      const message = host.querySelector(".replay-message");
      message.hidden = false;
      message.textContent = `The motion cannot be shown: ${error.message}`;
      console.error(error);
    }
  }
  theme.addEventListener("change", () => {
    document.documentElement.dataset.dark = theme.matches;
    for (const replay of window.replays) { replay.floor(); replay.viewer.set_dirty(); }
  });
})();
