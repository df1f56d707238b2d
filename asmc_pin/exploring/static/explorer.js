// The explorer: joint values, M̄ and gains in, all figures of that configuration out, at once.
"use strict";
(() => {
  const { element, named, figure, JointFields, PositiveFields } = AsmcFields;
  const { PROVEN, REFUTED } = AsmcCells;
  const one = (selector) => document.querySelector(selector);
  const later = (act, wait) => {
    let timer = 0;
    return () => { clearTimeout(timer); timer = setTimeout(act, wait); };
  };

  class Explorer {
    constructor(data) {
      this.data = data;
      this.n = data.joints.length;
      this.mass = new AsmcMass.MassMatrix(data.links);
      this.lower = data.joints.map(({ lower }) => lower);
      this.upper = data.joints.map(({ upper }) => upper);
      this.q = Float64Array.from(data.start);
      this.given = Float64Array.from(data.mbar);
      this.own = this.given.slice();
      this.scale = 1;
      this.gains = { ...data.gains };
      this.plane = [...data.plane];
      this.cells = data.cells ? new AsmcCells.ProvenCells(data.cells, this.lower, this.upper) : null;
      this.build();
      this.drawMap = later(() => this.startMap(), 60);
      this.tell = later(() => this.tellAloud(), 500);
      this.ask = later(() => this.askCollisions(), 120);
      this.showScene();
      this.update();
      addEventListener("beforeprint", () => {
        this.stage?.still(one("h1").textContent);
        this.startMap();
        this.map?.finish();
      });
    }

    get mbar() { return this.own.map((value) => this.scale * value); }

    get changed() { return this.scale !== 1 || this.own.some((value, k) => value !== this.given[k]); }

    normAt(q, mbar) { return AsmcCondition.norm(this.data.condition, this.mass.at(q), mbar, this.n); }

    build() {
      const { data } = this, { joints } = data;
      this.jointFields = new JointFields(one(".joints"), joints, (k, value) => this.move(k, value));
      const scale = { name: "all of M̄, times", unit: "", id: "mbar-scale" };
      const own = joints.map(({ name, prismatic }, k) => ({ name, unit: prismatic ? "kg" : "kg·m²", id: `mbar-${k}` }));
      this.mbarFields = new PositiveFields(one(".mbar"), [scale, ...own], [1, ...this.own], (k, value) => {
        if (k) this.own[k - 1] = value;
        else this.scale = value;
        this.newMbar();
      });
      const gains = [["ks", "k_s", "1/s"], ["beta", "β", "1/s"], ["period", "L", "s"]];
      const items = gains.map(([key, name, unit]) => ({ name, unit, id: `gain-${key}` }));
      this.gainFields = new PositiveFields(one(".loop"), items, gains.map(([key]) => this.gains[key]), (k, value) => {
        this.gains[gains[k][0]] = value;
        this.update();
      });
      for (const [axis, selector] of [".map-across", ".map-up"].entries()) {
        const select = one(selector);
        joints.forEach(({ name }, k) => element(select, "option", { value: k }, name));
        select.value = this.plane[axis];
        select.addEventListener("change", () => this.choosePlane(axis, Number(select.value)));
      }
      const bars = one(".direction");
      this.bars = joints.map(({ name }) => {
        const row = element(bars, "div", { class: "bar" });
        named(row, "span", { class: "bar-name" }, name);
        const track = element(row, "span", { class: "bar-track", "aria-hidden": "true" });
        return { fill: element(track, "i"), value: element(row, "span", { class: "bar-value" }) };
      });
      one(".to-worst").addEventListener("click", () => this.go(data.worst.q));
      one(".to-rest").addEventListener("click", () => this.go(data.start));
      one(".mbar-back").addEventListener("click", () => {
        this.own = this.given.slice();
        this.scale = 1;
        this.mbarFields.show([1, ...this.own]);
        this.newMbar();
      });
      this.search = new AsmcSearch.NormSearch(this.lower, this.upper, (q, mbar) => this.normAt(q, mbar));
      one(".search").addEventListener("click", () => this.searchWorst());
      if (this.n > 1) {
        this.map = new AsmcMap.NormMap(one(".map"), this.lower, this.upper, {
          normAt: (q, mbar) => this.normAt(q, mbar),
          picked: (x, y) => {
            [this.q[this.plane[0]], this.q[this.plane[1]]] = [x, y];
            this.update();
          },
          told: () => this.tellMap(),
        });
      } else one(".map-panel").hidden = true;
    }

    showScene() {
      try {
        this.stage = new AsmcScene.Stage(one(".replay-stage"), this.data.scene, true);
        this.stage.show({ paths: false });
        this.stage.arms[0].set(this.q);
        this.stage.resetView();
        this.dragging = new AsmcDragging.ArmDragging(this.stage, { where: () => this.q, move: (k, value) => this.move(k, value) });
        one(".reset-view").addEventListener("click", () => this.stage.resetView());
        matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.stage.floor());
        const tick = () => { requestAnimationFrame(tick); this.stage.render(); };
        tick();
      } catch (error) {
        this.stage = null;
        one(".scene-panel .replay").hidden = true;
        one(".scene-message").hidden = false;
        one(".scene-message").textContent = `The arm cannot be drawn here (${error.message}); all figures are computed all the same.`;
      }
    }

    move(k, value) {
      if (!Number.isFinite(value)) return;
      this.q[k] = Math.min(Math.max(value, this.lower[k]), this.upper[k]);
      this.update();
    }

    go(q) {
      this.q.set(q);
      this.update();
    }

    choosePlane(axis, joint) {
      if (this.plane[1 - axis] === joint) this.plane[1 - axis] = this.plane[axis];  // two joints, or no plane
      this.plane[axis] = joint;
      one(".map-across").value = this.plane[0];
      one(".map-up").value = this.plane[1];
      this.update();
    }

    newMbar() {
      this.search.stop();
      one(".mbar-note").textContent = this.changed
        ? "This M̄ is not the one that was asked about. The worst configuration above was found for that one; a search here looks for one of this M̄."
        : "";
      this.update();
    }

    searchWorst() {
      const note = one(".mbar-note");
      note.textContent = "Searching …";
      this.search.begin(this.mbar, [this.q, Float64Array.from(this.data.worst.q)], ({ q, norm, count }) => {
        const verdict = norm < 1 ? "no configuration that violates the condition was found" : "it violates the condition";
        note.textContent = `Largest norm that ${count} configurations of the joint box came to for this M̄: ${figure(norm, 6)}; ${verdict}. The sliders are there now. A search proves nothing; asmc-pin verify looks further.`;
        this.go(q);
      });
    }

    // All that follows from q, M̄ and the gains.
    update() {
      const { data, n, mbar, q } = this;
      this.M = this.mass.at(q, this.M);
      this.here = AsmcCondition.at(data.condition, this.M, mbar, n);
      this.jointFields.show(q);
      if (this.stage) {
        this.stage.arms[0].set(q);
        this.stage.viewer.set_dirty();
      }
      if (!this.here) return;  // no inertia of an arm that was loaded is not positive definite
      this.loop = AsmcCondition.loop(this.here.ratios, this.gains);
      this.showNorm();
      this.showFigures();
      this.showLoop();
      this.map?.canvas.classList.add("is-stale");
      this.map?.giveUp();
      this.map?.mark(q);
      this.drawMap();
      this.tell();
      if (data.live) this.ask();
    }

    showNorm() {
      const { norm } = this.here, over = !(norm < 1);
      one(".norm").textContent = figure(norm, 6);
      one(".state").textContent = over ? "1 or more: violated here" : "below 1: satisfied here";
      document.body.classList.toggle("is-over", over);
      if (this.stage) {
        this.stage.labels[0].value.textContent = `norm ${figure(norm)}`;
        this.stage.labels[0].label.classList.toggle("is-over", over);
      }
    }

    showFigures() {
      const { here, data } = this, blamed = here.slopes.reduce((best, x, k, all) => (Math.abs(x) > Math.abs(all[best]) ? k : best), 0);
      const mixed = new Set(data.joints.map(({ prismatic }) => prismatic)).size > 1;
      const unit = mixed ? " (rad and m mixed: they depend on the units)" : data.joints[0].prismatic ? " kg" : " kg·m²";
      const rows = [
        ["M̄ may be multiplied here by", here.breaks > 0 ? `less than ${figure(here.breaks)}` : "nothing: no multiple satisfies the condition here"],
        ["m̄ that moves the norm most", `that of ${data.joints[blamed].name}: ${here.slopes[blamed] > 0 ? "smaller" : "larger"} lowers it`],
        ["Eigenvalues of M", here.inertias.map((x) => figure(x)).join(", ") + unit],
        ["Eigenvalues of M⁻¹M̄", here.ratios.map((x) => figure(x)).join(", ")],
      ];
      const list = one(".figures");
      list.replaceChildren();
      for (const [term, value] of rows) {
        element(list, "dt", {}, term);
        element(list, "dd", {}, value);
      }
      const largest = Math.max(...here.direction.map(Math.abs));
      const sign = here.direction.find((x) => Math.abs(x) === largest) < 0 ? -1 : 1;
      this.bars.forEach(({ fill, value }, k) => {
        const share = sign * here.direction[k];
        fill.style.width = `${50 * Math.abs(share)}%`;
        fill.style.left = `${share < 0 ? 50 * (1 + share) : 50}%`;
        value.textContent = share.toFixed(3).replace("-", "−");
      });
    }

    showLoop() {
      const { radius, beta, ks, together } = this.loop, most = (x) => (x === Infinity ? "any" : x > 0 ? `below ${figure(x, 4)} 1/s` : "none");
      const ends = together > 0
        ? `With the other gain as it is, stable for β: ${most(beta)}; k_s: ${most(ks)}. Both together may be multiplied by ${together === Infinity ? "anything" : `less than ${figure(together, 4)}`}.`
        : "No β and no k_s are stable here: an eigenvalue of M⁻¹M̄ is 2 or more.";
      one(".loop-words").textContent =
        `${radius < 1 ? "Stable" : "Unstable"} at this configuration: spectral radius ${figure(radius, 6)}. ${ends}`;
    }

    // Which boxes say something of the M̄ in the fields: a proof of M̄ times f is one of every smaller multiple.
    get cellsApply() { return this.cells && this.own.every((value, k) => value === this.given[k]) && this.scale <= this.cells.scale; }

    startMap() {
      if (!this.map) return;
      const cells = this.cellsApply ? this.cells.meeting(this.plane, this.q) : [];
      // Below the M̄ that was asked about a counter-example of it is none.
      const known = this.scale < 1 ? cells.map((cell) => (cell.mark === REFUTED ? { ...cell, mark: AsmcCells.OPEN } : cell)) : cells;
      this.map.compute(this.plane, this.q, this.mbar, known);
    }

    tellMap() {
      const { map, data } = this, { least, most, over, at } = map.extremes(), [x, y] = map.plane;
      const { places } = this.jointFields, name = (k) => data.joints[k].name;
      map.canvas.classList.remove("is-stale");
      const all = "at all of its points", some = `on ${figure(100 * over, 3)} % of its points (orange, inside the black line)`;
      const share = over === 0 ? `below 1 ${all}` : `1 or more ${over === 1 ? `${all} (orange)` : some}`;
      one(".map-words").textContent =
        `From ${figure(least)}${over === 1 ? "" : " (dark)"} to ${figure(most)}, ${share}; largest at ${name(x)} ${places[x].words(at[0])}, ${name(y)} ${places[y].words(at[1])}. The circle is where the sliders are; a click moves them.`;
      map.canvas.setAttribute("aria-label", `Map of the norm over ${name(x)} and ${name(y)}: from ${figure(least)} to ${figure(most)}`);
      const ends = (selector, k) => [...document.querySelectorAll(`${selector} span`)].forEach((span, end) => {
        span.textContent = places[k].words(end ? this.upper[k] : this.lower[k]);
      });
      ends(".map-across-ends", x);
      ends(".map-up-ends", y);
      one(".cells-words").textContent = this.cellsWords(map.cells);
    }

    cellsWords(cells) {
      if (!this.cells) return this.data.cellsNote;
      if (!this.cellsApply) return `The boxes are of M̄ times ${figure(this.cells.scale, 6)} as asked about and say nothing of this one: not shown.`;
      const count = (mark) => cells.filter((cell) => cell.mark === mark).length;
      const proven = count(PROVEN), refuted = count(REFUTED), rest = cells.length - proven - refuted;
      return `${this.data.cellsNote} Of those that meet this plane ${proven} are proven (white edge), ${refuted} hold a configuration that violates the condition (black edge, crossed out) and ${rest} are open (dashed).`;
    }

    async askCollisions() {
      const line = one(".collisions"), asked = Array.from(this.q);
      try {
        const answer = await fetch(`collisions?q=${asked.join(",")}`);
        if (!answer.ok) throw new Error(`status ${answer.status}`);
        const { text } = await answer.json();
        if (asked.every((value, k) => value === this.q[k])) line.textContent = text;
      } catch {
        line.textContent = "Whether links collide is not known: the server does not answer any more.";
      }
    }

    tellAloud() {
      const { here, loop } = this;
      one(".told").textContent = `Norm ${figure(here.norm, 4)}, ${here.norm < 1 ? "below 1" : "1 or more"}. Loop ${loop.radius < 1 ? "stable" : "unstable"} here.`;
    }
  }

  const data = JSON.parse(document.getElementById("explored").textContent);
  data.live = data.live && location.protocol === "http:";
  window.explorer = new Explorer(data);
})();
