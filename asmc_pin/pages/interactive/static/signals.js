// Curves of every joint, drawn by BokehJS: one quantity at a time, a cursor that moves with the replay, a click that
// moves the replay. Expects Bokeh and its API and timeline.js, inlined above.
"use strict";
(() => {
  const dark = matchMedia("(prefers-color-scheme: dark)");
  const coarse = matchMedia("(pointer: coarse)");
  const element = (parent, tag, attributes = {}, text = "") => {
    const made = document.createElement(tag);
    for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
    made.textContent = text;
    parent.append(made);
    return made;
  };

  // Half precision to numbers.
  const half = (bits) => {
    const sign = bits & 0x8000 ? -1 : 1, exponent = (bits >> 10) & 31, fraction = bits & 1023;
    if (exponent === 31) return NaN;
    return sign * (exponent ? 2 ** (exponent - 15) * (1 + fraction / 1024) : 2 ** -14 * fraction / 1024);
  };
  const numbers = (packed) => {
    if (packed === null) return null;
    const raw = new Uint16Array(Uint8Array.from(atob(packed.data), (c) => c.charCodeAt(0)).buffer);
    return Float64Array.from(raw, (bits) => packed.scale * half(bits));
  };
  const size = (values) => values.map((value) => Math.abs(value) || NaN);

  class Signals {
    constructor(host) {
      this.host = host;
      this.data = JSON.parse(host.querySelector("script[type='application/json']").textContent);
      this.off = this.data.controllers.map(() => false);
      this.joints = this.data.joints.map(() => true);
      this.signal = this.data.signals[0];
      this.logarithmic = false;
      this.time = window.replays?.[0]?.time ?? this.wish() ?? 0;  // the replay may have been opened at a time
      this.plots = [];
      this.range = { start: 0, end: this.data.duration };
      this.dragging = coarse.matches ? "scroll" : "move";
      this.buildControls();
      const place = host.querySelector(".signals-plots");
      place.addEventListener("pointerdown", () => this.letWheelZoom(true));
      place.addEventListener("pointerleave", () => this.letWheelZoom(false));
      this.ready = this.draw();
      const again = () => { this.ready = this.draw(); };
      dark.addEventListener("change", again);
      document.addEventListener("replay-time", (event) => { this.time = event.detail; this.moveCursor(); });
      document.addEventListener("controller-shown", (event) => this.showController(event.detail.label, event.detail.on));
      addEventListener("hashchange", () => { if (!window.replays?.length && this.wish() !== null) this.seek(this.wish()); });
      new ResizeObserver(() => this.moveCursor()).observe(host);
    }

    buildControls() {
      const bar = this.host.querySelector(".signals-controls");
      const select = element(element(bar, "label", {}, "Quantity "), "select");
      for (const { key, title } of this.data.signals) element(select, "option", { value: key }, title);
      select.addEventListener("change", () => {
        this.signal = this.data.signals.find(({ key }) => key === select.value);
        this.ready = this.draw();
      });
      this.select = select;
      const box = (parent, text, checked, act) => {
        const label = element(parent, "label"), input = element(label, "input", { type: "checkbox" });
        input.checked = checked;
        label.append(` ${text}`);
        input.addEventListener("change", () => act(input.checked));
        return input;
      };
      this.log = box(bar, "Logarithmic", false, (on) => { this.logarithmic = on; this.ready = this.draw(); });
      const drag = element(element(bar, "label", {}, "Dragging "), "select");
      for (const [value, text] of [["move", "moves along"], ["box", "zooms"], ["scroll", "scrolls the page"]]) element(drag, "option", { value }, text);
      drag.value = this.dragging;
      drag.addEventListener("change", () => {
        this.dragging = drag.value;
        for (const { plot } of this.plots) plot.toolbar.active_drag = this.dragTool(plot);
      });
      const joints = element(bar, "fieldset", { class: "signals-joints" });
      element(joints, "legend", {}, "Joints");
      this.data.joints.forEach((name, j) => box(joints, name, true, (on) => {
        this.joints[j] = on;
        this.plots[j].figure.hidden = !on;
        this.moveCursor();
      }));
      element(bar, "button", { type: "button" }, "Reset zoom").addEventListener("click", () => this.reset());
    }

    reset() {
      this.range.setv({ start: 0, end: this.data.duration });
      for (const { plot } of this.plots) plot.y_range.reset?.();
    }

    colour(k) {
      const { colour } = this.data.controllers[k];
      return dark.matches && colour === "#000000" ? "#e8ecf1" : colour;  // black would be lost on a dark page
    }

    // One plot a joint, the old ones away.
    async draw() {
      const turn = this.turn = (this.turn ?? 0) + 1, { start, end } = this.range;
      this.range = new Bokeh.Range1d({ start, end, bounds: [0, this.data.duration] });
      this.range.change.connect(() => this.moveCursor());
      const place = this.host.querySelector(".signals-plots"), made = document.createElement("div");
      made.className = "signals-grid";
      place.replaceChildren(made);
      const document_ = new Bokeh.Document();
      this.plots = this.data.joints.map((name, j) => {
        const figure = element(made, "figure", { class: "signals-figure", "aria-label": this.spoken(j) });
        figure.hidden = !this.joints[j];
        element(figure, "figcaption", {}, `${name}: ${this.signal.title} [${this.signal.units[j]}] over time [s]`);
        const body = element(figure, "div", { class: "signals-body" }), { plot, renderers } = this.plot(j);
        document_.add_root(plot);
        return { figure, body, plot, renderers, cursor: null, view: null };
      });
      const views = await Bokeh.embed.add_document_standalone(document_, made, this.plots.map(({ body }) => body));
      if (turn !== this.turn) return;
      for (const entry of this.plots) {
        entry.view = views.get(entry.plot);
        entry.cursor = element(entry.body, "div", { class: "signals-cursor", "aria-hidden": "true" });
      }
      this.host.querySelector(".signals-words").textContent = this.told();
      this.moveCursor();
    }

    plot(j) {
      const { Plotting } = Bokeh, ink = dark.matches ? "#a5b0be" : "#566173", line = dark.matches ? "#323943" : "#dde2e8";
      const plot = Plotting.figure({
        height: 190, sizing_mode: "stretch_width", tools: ["xpan", "xwheel_zoom", "box_zoom"], toolbar_location: null,
        x_range: this.range, y_axis_type: this.logarithmic ? "log" : "linear", background_fill_alpha: 0, border_fill_alpha: 0,
        outline_line_color: line, min_border_left: 62, min_border_right: 12, output_backend: "canvas",
      });
      plot.toolbar.logo = null;
      plot.toolbar.active_scroll = null;
      plot.toolbar.active_drag = this.dragTool(plot);
      plot.y_range.only_visible = true;
      for (const axis of [...plot.xaxis, ...plot.yaxis]) {
        Object.assign(axis, { axis_line_color: line, major_tick_line_color: line, minor_tick_line_color: null, major_label_text_color: ink, major_label_text_font_size: "12px" });
      }
      for (const grid of [...plot.xgrid, ...plot.ygrid]) grid.grid_line_color = line;
      const x = Float64Array.from(this.data.points), middle = x.filter((_, k) => k % 2 === 0).map((t, k) => (t + x[2 * k + 1]) / 2);
      const renderers = this.data.controllers.map(({ label }, k) => {
        const own = [], line_color = this.colour(k), curve = numbers(this.signal.curves[k][j]);
        const band = this.signal.bands?.[k][j].map(numbers);
        if (band && band[0]) {
          let [y1, y2] = band;
          if (this.logarithmic) [y1, y2] = [y1.map((low, i) => (low * y2[i] <= 0 ? NaN : Math.min(Math.abs(low), Math.abs(y2[i])))), y1.map((low, i) => Math.max(Math.abs(low), Math.abs(y2[i])) || NaN)];
          const source = new Bokeh.ColumnDataSource({ data: { x: middle, y1, y2 } });
          own.push(plot.varea({ field: "x" }, { field: "y1" }, { field: "y2" }, { source, fill_color: line_color, fill_alpha: 0.25 }));
        }
        if (curve) {
          const source = new Bokeh.ColumnDataSource({ data: { x, y: this.logarithmic ? size(curve) : curve } });
          const drawn = plot.line({ field: "x" }, { field: "y" }, { source, line_color, line_width: 1.4, line_join: "round", name: label });
          plot.add_tools(new Bokeh.HoverTool({ renderers: [drawn], mode: "vline", line_policy: "nearest", point_policy: "snap_to_data", tooltips: [[label, "$snap_y{0.000e+0}"], ["t", "$snap_x{0.000} s"]] }));
          own.push(drawn);
        }
        for (const renderer of own) renderer.visible = !this.off[k];
        return own;
      });
      plot.on_event("tap", (event) => this.seek(event.x));
      return { plot, renderers };
    }

    // What dragging does; on a touch screen nothing unless it was asked for, for the page has to scroll.
    dragTool(plot) {
      const wanted = { move: "PanTool", box: "BoxZoomTool", scroll: "" }[this.dragging];
      return plot.toolbar.tools.find((tool) => tool.type === wanted) ?? null;
    }

    // The wheel zooms once the plots were clicked; till then, and when the pointer has left, it scrolls the page.
    letWheelZoom(on) {
      for (const { plot } of this.plots) {
        plot.toolbar.active_scroll = on ? plot.toolbar.tools.find((tool) => tool.type === "WheelZoomTool") ?? null : null;
      }
    }

    seek(time) {
      for (const replay of window.replays ?? []) { replay.pause(); replay.seek(time); }
      if (!window.replays?.length) { this.time = time; this.moveCursor(); }
    }

    // The time that the address asks for, for where no replay answers it.
    wish() {
      const time = AsmcTimeline.wished();
      return time === null ? null : Math.min(time, this.data.duration);
    }

    // Where the replay is, in every plot that shows that time.
    moveCursor() {
      const { start, end } = this.range;
      for (const { cursor, view, figure } of this.plots) {
        if (!cursor || figure.hidden) continue;
        const inside = this.time >= start && this.time <= end, { frame } = view;
        cursor.hidden = !inside;
        if (!inside) continue;
        const { left, top, width, height } = frame.bbox;
        Object.assign(cursor.style, { left: `${left + width * (this.time - start) / (end - start)}px`, top: `${top}px`, height: `${height}px` });
      }
    }

    // The time that the cursor of a plot stands at, as its place in the picture says.
    cursorTime(j) {
      const { cursor, view } = this.plots[j], { left, width } = view.frame.bbox, { start, end } = this.range;
      return start + (end - start) * (parseFloat(cursor.style.left) - left) / width;
    }

    showController(label, on) {
      this.data.controllers.forEach((controller, k) => {
        if (controller.label !== label) return;
        this.off[k] = !on;
        for (const { renderers } of this.plots) for (const renderer of renderers[k]) renderer.visible = on;
      });
      this.host.querySelector(".signals-words").textContent = this.told();
    }

    spoken(j) {
      const unit = this.signal.units[j];
      const parts = this.data.controllers.map(({ label }, k) => {
        const most = this.signal.words[k][j];
        return most ? `${label} at most ${most[0]} ${unit} at ${most[1]} s` : `${label} none`;
      });
      return `${this.signal.title} of ${this.data.joints[j]} over ${this.data.duration} s${this.data.kept}: ${parts.join(", ")}`;
    }

    told() {
      const shown = this.data.controllers.map(({ label }) => label).filter((_, k) => !this.off[k]);
      return `Shown: ${this.signal.title} of ${shown.length ? shown.join(", ") : "no controller"}.`;
    }
  }

  Bokeh.logger.set_level("error");  // it tells of every document
  window.signalFigures = [...document.querySelectorAll(".signals")].map((host) => new Signals(host));
})();
