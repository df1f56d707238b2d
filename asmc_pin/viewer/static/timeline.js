// The largest joint error over time, above the slider, with marks where something happens, so that the time of trouble
// can be found; and the list of those times.
"use strict";
const AsmcTimeline = (() => {
  const { element } = AsmcScene;
  const svg = (parent, tag, attributes) => {
    const made = document.createElementNS("http://www.w3.org/2000/svg", tag);
    for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
    parent.append(made);
    return made;
  };

  // The chart of a replay; returns what moves its cursor to a time.
  const chart = (replay, track, marks) => {
    const { motions, colours, duration } = replay, { errors, last, count } = motions;
    const curves = errors.map((values, a) => Array.from(values.slice(0, last[a] + 1)));
    const top = curves.flat().reduce((x, y) => Math.max(x, y), 1e-12);
    // Errors that are far apart stand on a logarithmic axis, as in the figures.
    const sizes = curves.map((values) => Math.sqrt(values.reduce((sum, e) => sum + e * e, 0) / values.length)).filter((size) => size > 0);
    const far = Math.max(...sizes) > 15 * Math.min(...sizes), floor = Math.max(Math.min(...sizes) / 10, 1e-6 * top);
    const height = far ? (e) => Math.log(Math.max(e, floor) / floor) / Math.log(top / floor) : (e) => e / top;
    const scale = far ? `from ${motions.format(floor)}, logarithmic` : "from 0";
    element(track, "div", { class: "replay-top" }, `Largest joint error over time, ${scale}, to ${motions.format(top)}`);
    const picture = svg(track, "svg", { viewBox: "0 0 1000 100", preserveAspectRatio: "none", class: "replay-chart", "aria-hidden": "true" });
    for (const { kind, start, end } of marks) {
      if (kind === "place") continue;  // in the list alone
      const x = 1000 * start / duration, width = 1000 * ((end ?? start) - start) / duration;
      svg(picture, "rect", { class: `replay-mark-${kind}`, x, y: 0, width: Math.max(width, 3), height: 100 });
    }
    curves.forEach((values, a) => {
      const points = values.map((e, k) => `${(1000 * k / (count - 1)).toFixed(1)},${(97 - 92 * height(e)).toFixed(1)}`);
      svg(picture, "polyline", { points: points.join(" "), stroke: colours[a] });
    });
    const cursor = svg(picture, "line", { x1: 0, x2: 0, y1: 0, y2: 100 });
    const jump = (event) => {
      const { left, width } = picture.getBoundingClientRect();
      replay.seek(duration * (event.clientX - left) / width);
    };
    picture.addEventListener("pointerdown", (event) => { replay.pause(); picture.setPointerCapture(event.pointerId); jump(event); });
    picture.addEventListener("pointermove", (event) => { if (event.buttons) jump(event); });
    return (time) => cursor.setAttribute("transform", `translate(${1000 * time / (duration || 1)} 0)`);
  };

  // What happens, by its words: choosing one takes the scene there.
  const places = (replay, bar, marks) => {
    const select = element(element(bar, "label", { class: "replay-moving" }, "Go to"), "select");
    element(select, "option", { value: "" }, "a time …");
    marks.forEach(({ words }, k) => element(select, "option", { value: k }, words));
    select.addEventListener("change", () => {
      if (select.value === "") return;
      replay.pause();
      replay.seek(marks[Number(select.value)].start);
      select.value = "";
    });
    return select;
  };

  // The time that the page's address asks for, s: #t=2.5; null where it asks for none.
  const wished = () => {
    const wish = /^#t=(\d+\.?\d*|\.\d+)$/.exec(location.hash);
    return wish && Number(wish[1]);
  };

  return { chart, places, svg, wished };
})();
