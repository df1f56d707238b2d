// Plays joint motions on the stage of scene.js: time, controls, and the error under each arm.
"use strict";
(() => {
  const { Stage, element } = AsmcScene, { bytes } = AsmcArm, { chart, places, svg, wished } = AsmcTimeline;
  const floats = (text) => new Float32Array(bytes(text).buffer);
  // Keys that move the camera: around, up and down, and by which factor nearer.
  const SHIFTED = { ArrowLeft: [-0.1, 0, 1], ArrowRight: [0.1, 0, 1], ArrowUp: [0, 0.1, 1], ArrowDown: [0, -0.1, 1] };
  const TURNS = { "+": [0, 0, 0.9], "=": [0, 0, 0.9], "-": [0, 0, 1 / 0.9] };

  // Joint values over time: of every motion, and of the reference.
  class Motions {
    constructor({ joints, motions, reference, duration }) {
      this.joints = joints;
      this.duration = duration;
      this.nv = joints.length;
      this.q = motions.map((motion) => floats(motion.q));
      this.reference = reference === null ? null : floats(reference);
      this.count = this.q[0].length / this.nv;
      this.step = this.count > 1 ? duration / (this.count - 1) : 1;
      this.shades = motions.map(({ shades }) => (shades ? floats(shades) : null));
      this.torques = motions.map(({ torque }) => (torque ? new Int8Array(bytes(torque).buffer) : null));
      this.readings = motions.map(({ reading }) => (reading ? { name: reading.name, values: floats(reading.values) } : null));
      this.ends = motions.map(({ end }) => (end === null ? null : end));
      this.last = this.ends.map((end) => (end === null ? this.count - 1 : Math.floor(end / this.step)));
      this.magnify = 1;
      // Of a mixed arm, the turning joints are told of.
      this.turning = joints.some((joint) => !joint.prismatic);
      this.unit = this.turning ? "°" : " mm";
      this.errors = this.reference ? this.q.map((q) => this.largestError(q)) : [];
    }

    // Largest joint error of every frame, in degrees, or in millimetres on an arm that only slides.
    largestError(q) {
      const factor = this.turning ? 180 / Math.PI : 1000;
      return Float64Array.from({ length: this.count }, (_, k) => this.joints.reduce((largest, joint, j) => (
        joint.prismatic === this.turning ? largest
          : Math.max(largest, factor * Math.abs(q[k * this.nv + j] - this.reference[k * this.nv + j]))), 0));
    }

    // Between two frames, joint by joint.
    at(values, frame) {
      const k = Math.min(Math.floor(frame), this.count - 1), next = Math.min(k + 1, this.count - 1), w = frame - k;
      return Array.from({ length: this.nv }, (_, j) => (1 - w) * values[k * this.nv + j] + w * values[next * this.nv + j]);
    }

    wanted(frame) { return this.at(this.reference, frame); }

    // What arm `a` shows: where it is, its difference from the reference magnified.
    shown(a, frame) {
      const until = Math.min(frame, this.last[a]), q = this.at(this.q[a], until);
      if (this.magnify === 1) return q;
      const wanted = this.wanted(until);
      return q.map((value, j) => wanted[j] + this.magnify * (value - wanted[j]));
    }

    // Torques of arm `a` over their limits, ±1 at the limit; after its end there are none.
    shares(a, frame) {
      const k = Math.round(Math.min(frame, this.count - 1)), { nv } = this;
      if (frame > this.last[a]) return new Array(nv).fill(0);
      return Array.from(this.torques[a].subarray(k * nv, (k + 1) * nv), (share) => share / 127);
    }

    frames() { return Array.from({ length: this.count }, (_, k) => k); }

    format(error) {
      return `${error.toFixed(error >= 100 ? 0 : error >= 10 ? 1 : error >= 1 ? 2 : 3)}${this.unit}`;
    }
  }

  class Replay {
    constructor(host) {
      this.host = host;
      this.embedded = host.dataset.embedded === "true";
      const data = JSON.parse(host.querySelector("script[type='application/json']").textContent);
      const dark = matchMedia("(prefers-color-scheme: dark)").matches;
      // The palette's black would be lost on a dark page.
      for (const motion of data.motions) if (dark && motion.colour === "#000000") motion.colour = "#e8ecf1";
      this.colours = data.motions.map((motion) => motion.colour);
      this.motions = new Motions(data);
      this.duration = data.duration;
      this.marks = data.marks;
      this.time = 0;
      this.playing = false;
      this.speed = 1;
      this.buildControls();
      this.stage = new Stage(host.querySelector(".replay-stage"), data, this.embedded);
      this.trace();
      this.stage.resetView();
      this.listen();
      this.seek(0);
      this.start();
    }

    trace() {
      const { motions } = this, frames = motions.frames();
      this.stage.trace((a) => frames.map((k) => motions.shown(a, k)), motions.reference ? frames.map((k) => motions.wanted(k)) : [], motions.shades);
    }

    seek(time) {
      const { motions, stage } = this;
      this.time = Math.min(Math.max(time, 0), this.duration);
      const frame = this.time / motions.step;
      stage.arms.forEach((arm, a) => {
        arm.set(motions.shown(a, frame));
        const k = 3 * Math.round(Math.min(frame, motions.count - 1));
        if (motions.torques[a]) arm.showTorques(motions.shares(a, frame));
        if (motions.shades[a]) arm.shade(...motions.shades[a].subarray(k, k + 3));
        this.describe(a, frame);
      });
      for (const ghost of stage.ghosts) ghost.set(motions.wanted(frame));
      this.slider.value = this.time;
      this.slider.setAttribute("aria-valuetext", `${this.time.toFixed(2)} seconds`);
      this.clock.textContent = `${this.time.toFixed(2)} s / ${this.duration.toFixed(2)} s`;
      this.moveCursor?.(this.time);
      stage.viewer.set_dirty();
      document.dispatchEvent(new CustomEvent("replay-time", { detail: this.time }));  // figures beside it move along
    }

    describe(a, frame) {
      const { label, value } = this.stage.labels[a], { ends, last, errors, readings, count } = this.motions;
      const over = ends[a] !== null && frame > last[a];
      label.classList.toggle("is-over", over);
      if (over) value.textContent = `diverged at ${Number(ends[a].toPrecision(3))} s`;
      else if (readings[a]) value.textContent = `${readings[a].name} ${readings[a].values[Math.round(Math.min(frame, count - 1))].toPrecision(5)}`;
      else if (errors.length) value.textContent = this.motions.format(errors[a][Math.round(Math.min(frame, count - 1))]);
    }

    play() {
      if (this.time >= this.duration) this.seek(0);
      this.playing = this.duration > 0;
      this.before = null;
      this.showState();
    }

    pause() {
      this.playing = false;
      this.showState();
    }

    toggle() {
      if (this.playing) this.pause();
      else this.play();
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
          const passed = this.before === null ? 0 : (now - this.before) / 1000;
          this.before = now;
          this.seek(this.time + passed * this.speed);
          if (this.time >= this.duration) {
            if (this.loop.checked) this.seek(0);
            else this.pause();
          }
        }
        this.stage.render();
      };
      requestAnimationFrame(tick);
      addEventListener("hashchange", () => this.seekWish());
      if (this.seekWish() || this.embedded || matchMedia("(prefers-reduced-motion: reduce)").matches) return;
      this.play();
    }

    // #t=2.5 opens the page at that time.
    seekWish() {
      const time = wished();
      if (time === null) return false;
      this.pause();
      this.seek(time);
      return true;
    }

    still() {
      this.stage.still(`The scene at ${this.time.toFixed(2)} s`);
    }

    buildControls() {
      const bar = element(this.host, "div", { class: "replay-controls" });
      if (this.motions.count < 2) this.host.classList.add("is-at-rest");  // nothing to play
      this.button = element(bar, "button", { type: "button", class: "replay-play" });
      const icon = svg(this.button, "svg", { viewBox: "0 0 24 24", "aria-hidden": "true" });
      svg(icon, "path", { class: "icon-play", d: "M7 4.5v15l13-7.5z" });
      svg(icon, "path", { class: "icon-pause", d: "M6 4.5h4.2v15H6zM13.8 4.5H18v15h-4.2z" });
      this.clock = element(bar, "output", { class: "replay-clock" });
      const track = element(bar, "div", { class: "replay-track" });
      if (this.motions.errors.length && this.motions.count > 1) this.moveCursor = chart(this, track, this.marks);
      this.slider = element(track, "input", { type: "range", min: 0, max: this.duration, step: "any", value: 0, "aria-label": "Time" });
      const choice = (text, options, chosen, act) => {
        const select = element(element(bar, "label", {}, text), "select");
        for (const value of options) element(select, "option", { value }, `${value}×`);
        select.value = String(chosen);
        select.addEventListener("change", () => act(Number(select.value)));
        return select;
      };
      const box = (text, checked, act) => {
        const label = element(bar, "label"), input = element(label, "input", { type: "checkbox" });
        input.checked = checked;
        label.append(text);
        input.addEventListener("change", () => act(input.checked));
        return input;
      };
      choice("Speed", [0.1, 0.25, 0.5, 1, 2, 4], 1, (speed) => { this.speed = speed; }).parentElement.classList.add("replay-moving");
      if (this.motions.reference) {
        const errors = choice("Errors", [1, 5, 20, 100], 1, (factor) => {
          this.motions.magnify = factor;
          this.stage.magnified(factor);
          this.trace();
          this.seek(this.time);
        });
        errors.parentElement.title = "Magnifies the arms' differences from the reference";
        box("Reference", true, (on) => this.stage.show({ reference: on }));
      }
      box("Path", true, (on) => this.stage.show({ paths: on })).parentElement.classList.add("replay-moving");
      if (this.motions.torques.some((torque) => torque)) {
        const torque = box("Torque", true, (on) => this.stage.show({ torques: on })).parentElement;
        torque.title = "Arcs at the joints: torque over the joint's limit, half a turn and red at it; without a limit, over the largest torque of the run";
      }
      if (this.motions.q.length > 1) box("On one base", false, (on) => this.stage.gather(on)).parentElement.title = "All arms on one base, tinted; the solid one is the reference";
      if (this.marks.length) places(this, bar, this.marks);
      this.loop = box("Loop", !this.embedded, () => {});
      this.loop.parentElement.classList.add("replay-moving");
      element(bar, "button", { type: "button" }, "Reset view").addEventListener("click", () => this.stage.resetView());
      this.showState();
    }

    listen() {
      this.button.addEventListener("click", () => this.toggle());
      this.slider.addEventListener("input", () => { this.pause(); this.seek(Number(this.slider.value)); });
      const keys = (event) => {
        if (event.ctrlKey || event.metaKey || event.altKey) return;
        if (event.shiftKey && event.key in SHIFTED) {
          this.stage.turn(...SHIFTED[event.key]);
          event.preventDefault();
          return;
        }
        const own = event.target.closest("input, select, button");
        if (event.key === " " && !own?.matches("select, button, [type=checkbox]")) this.toggle();
        else if (!own && event.key === "ArrowRight") { this.pause(); this.seek(this.time + this.motions.step); }
        else if (!own && event.key === "ArrowLeft") { this.pause(); this.seek(this.time - this.motions.step); }
        else if (!own && event.key === "Home") this.seek(0);
        else if (!own && event.key in TURNS) this.stage.turn(...TURNS[event.key]);
        else return;
        event.preventDefault();
      };
      document.addEventListener("controller-shown", (event) => this.stage.hide(event.detail.label, !event.detail.on));
      // In a report, space and the wheel scroll the page unless the replay has the focus.
      (this.embedded ? this.host : document).addEventListener("keydown", keys);
      if (!this.embedded) return;
      const { controls } = this.stage.viewer;
      this.host.tabIndex = 0;
      this.stage.host.addEventListener("pointerdown", () => { this.host.focus({ preventScroll: true }); controls.enableZoom = true; });
      this.host.addEventListener("focusout", () => { controls.enableZoom = false; });
    }
  }

  window.replays = [];
  for (const host of document.querySelectorAll(".replay")) {
    try {
      window.replays.push(new Replay(host));
    } catch (error) {
      const message = host.querySelector(".replay-message");
      host.classList.add("is-broken");
      message.hidden = false;
      message.textContent = `The motion cannot be shown: ${error.message}`;
      console.error(error);
    }
  }
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
    for (const replay of window.replays) replay.stage.floor();
  });
  // After whatever else the page does for paper, such as opening what is folded.
  document.addEventListener("DOMContentLoaded", () => addEventListener("beforeprint", () => {
    for (const replay of window.replays) replay.still();
  }));
})();
