// The norm over two joints as a picture, the other joints where they stand; computed between frames.
"use strict";
const AsmcMap = (() => {
  const { PROVEN, REFUTED } = AsmcCells;
  const SIDE = 48;
  const COLOURS = ["440154", "472d7b", "3b528b", "2c728e", "21918c", "28ae80", "5ec962", "addc30", "fde725"]
    .map((hex) => [0, 2, 4].map((k) => parseInt(hex.slice(k, k + 2), 16)));
  const OVER = [213, 94, 0];

  const shade = (share) => {
    const place = Math.min(Math.max(share, 0), 1) * (COLOURS.length - 1), k = Math.min(Math.floor(place), COLOURS.length - 2);
    return COLOURS[k].map((value, c) => Math.round(value + (place - k) * (COLOURS[k + 1][c] - value)));
  };

  class NormMap {
    // `normAt(q, mbar)` gives one figure, `picked(x, y)` is told of a click, `told()` when a map is done.
    constructor(canvas, lower, upper, { normAt, picked, told }) {
      Object.assign(this, { canvas, lower, upper, normAt, told });
      this.norms = null;
      this.cells = [];
      this.run = 0;
      const pick = (event) => {
        const { left, top, width, height } = canvas.getBoundingClientRect(), [x, y] = this.plane;
        const along = (k, share) => lower[k] + Math.min(Math.max(share, 0), 1) * (upper[k] - lower[k]);
        picked(along(x, (event.clientX - left) / width), along(y, 1 - (event.clientY - top) / height));
      };
      // Where it is let go, or dragged to on the way; a finger that goes up or down scrolls the page and picks nothing.
      // Its first moves come before the browser has decided that it scrolls.
      let from = [0, 0];
      canvas.addEventListener("pointerdown", (event) => {
        from = [event.clientX, event.clientY];
        canvas.setPointerCapture(event.pointerId);
      });
      canvas.addEventListener("pointermove", (event) => {
        const [aside, along] = [Math.abs(event.clientX - from[0]), Math.abs(event.clientY - from[1])];
        if (event.buttons & 1 && (event.pointerType !== "touch" || aside > Math.max(10, along))) pick(event);
      });
      canvas.addEventListener("click", pick);
      new ResizeObserver(() => this.draw()).observe(canvas);
    }

    // Where the norms are taken: in the middle of SIDE equal parts of each range.
    place(k, i) { return this.lower[k] + (this.upper[k] - this.lower[k]) * (i + 0.5) / SIDE; }

    // What is under way is of something that has changed meanwhile: it is not to be shown as if it were of now.
    giveUp() { this.run += 1; }

    // Begin a map; one that is under way is given up.
    compute(plane, q, mbar, cells) {
      const [x, y] = plane, point = Array.from(q), norms = new Float64Array(SIDE * SIDE), run = ++this.run;
      let k = 0;
      this.busy = true;
      const go = (until = performance.now() + 12) => {
        if (run !== this.run || k >= norms.length) return;
        for (; k < norms.length && performance.now() < until; k++) {
          point[x] = this.place(x, k % SIDE);
          point[y] = this.place(y, Math.floor(k / SIDE));
          norms[k] = this.normAt(point, mbar);
        }
        if (k < norms.length) {
          setTimeout(() => go());
          return;
        }
        Object.assign(this, { plane, norms, cells, busy: false });
        this.draw();
        this.told();
      };
      this.finish = () => go(Infinity);  // paper does not wait for frames
      go();
    }
    // Least and largest norm, where the largest is, and the share of the map that is 1 or more.
    extremes() {
      const { norms, plane } = this;
      let least = Infinity, most = -Infinity, where = 0, over = 0;
      norms.forEach((value, k) => {
        if (value < least) least = value;
        if (value > most) [most, where] = [value, k];
        if (!(value < 1)) over += 1;
      });
      return { least, most, over: over / norms.length, at: [this.place(plane[0], where % SIDE), this.place(plane[1], Math.floor(where / SIDE))] };
    }

    mark(q) {
      this.here = q;
      this.draw();
    }

    draw() {
      const { canvas, norms } = this;
      const width = canvas.clientWidth, height = canvas.clientHeight, ratio = window.devicePixelRatio || 1;
      if (!norms || !width || !height) return;
      canvas.width = Math.round(width * ratio);
      canvas.height = Math.round(height * ratio);
      const pen = canvas.getContext("2d");
      pen.scale(ratio, ratio);
      this.paint(pen, width, height);
      this.outline(pen, width, height);
      for (const cell of this.cells) this.box(pen, cell, width, height);
      if (this.here) this.cross(pen, width, height);
    }

    paint(pen, width, height) {
      const { norms } = this, { least, most } = this.extremes(), top = Math.min(most, 1);
      const small = document.createElement("canvas");
      small.width = small.height = SIDE;
      const inside = small.getContext("2d"), picture = inside.createImageData(SIDE, SIDE);
      norms.forEach((value, k) => {
        const row = SIDE - 1 - Math.floor(k / SIDE);
        const colour = value < 1 ? shade((value - least) / (top - least || 1)) : OVER;
        picture.data.set([...colour, 255], 4 * (row * SIDE + k % SIDE));
      });
      inside.putImageData(picture, 0, 0);
      pen.imageSmoothingEnabled = false;
      pen.drawImage(small, 0, 0, width, height);
    }

    // A line where the norm passes 1: it is seen in grey as well.
    outline(pen, width, height) {
      const { norms } = this, over = (i, j) => !(norms[j * SIDE + i] < 1);
      pen.beginPath();
      for (let j = 0; j < SIDE; j++) {
        for (let i = 0; i < SIDE; i++) {
          const x = (i + 1) * width / SIDE, y = height - (j + 1) * height / SIDE;
          if (i + 1 < SIDE && over(i, j) !== over(i + 1, j)) { pen.moveTo(x, y); pen.lineTo(x, y + height / SIDE); }
          if (j + 1 < SIDE && over(i, j) !== over(i, j + 1)) { pen.moveTo(x - width / SIDE, y); pen.lineTo(x, y); }
        }
      }
      pen.strokeStyle = "#000000";
      pen.lineWidth = 2;
      pen.stroke();
    }

    // A proven box has a white edge, one with a counter-example a black one and, if there is room, a cross, one that is open has a dashed edge.
    box(pen, { mark, x0, x1, y0, y1 }, width, height) {
      const across = (value) => width * (value - this.lower[this.plane[0]]) / (this.upper[this.plane[0]] - this.lower[this.plane[0]]);
      const up = (value) => height * (1 - (value - this.lower[this.plane[1]]) / (this.upper[this.plane[1]] - this.lower[this.plane[1]]));
      const [left, right, top, bottom] = [across(x0), across(x1), up(y1), up(y0)];
      const edge = (colour, thick) => {
        pen.strokeStyle = colour;
        pen.lineWidth = thick;
        pen.strokeRect(left + 0.5, top + 0.5, Math.max(right - left - 1, 0), Math.max(bottom - top - 1, 0));
      };
      edge("rgb(0 0 0 / .45)", 2.4);
      pen.setLineDash(mark === PROVEN || mark === REFUTED ? [] : [3, 3]);
      edge(mark === REFUTED ? "#000000" : "#ffffff", 1);
      if (mark === REFUTED && Math.min(right - left, bottom - top) > 12) {
        pen.beginPath();
        pen.moveTo(left, top);
        pen.lineTo(right, bottom);
        pen.moveTo(left, bottom);
        pen.lineTo(right, top);
        pen.stroke();
      }
      pen.setLineDash([]);
    }

    cross(pen, width, height) {
      const share = (k) => (this.here[k] - this.lower[k]) / (this.upper[k] - this.lower[k] || 1);
      const x = width * share(this.plane[0]), y = height * (1 - share(this.plane[1]));
      for (const [colour, thick] of [["#000000", 5], ["#ffffff", 2.2]]) {
        pen.strokeStyle = colour;
        pen.lineWidth = thick;
        pen.beginPath();
        pen.arc(x, y, 7, 0, 2 * Math.PI);
        pen.stroke();
      }
    }
  }

  return { NormMap };
})();
