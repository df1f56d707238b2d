// Joint boxes of which something is known, cut with a plane: two joints free, the others where they stand.
"use strict";
const AsmcCells = (() => {
  const PROVEN = 255, REFUTED = 254, OPEN = 253;

  // The cells of one branch that meet the plane. `record` has a byte for each box in preorder: the joint that it was
  // halved at, the lower half first, or what is known of it.
  const ofBranch = (record, lower, upper, q, plane) => {
    const found = [], low = Array.from(lower), high = Array.from(upper);
    let at = 0;
    const skip = () => {
      for (let open = 1; open > 0; at++) open += record[at] >= OPEN ? -1 : 1;
    };
    const visit = () => {
      const joint = record[at];
      at += 1;
      if (joint >= OPEN) {
        const [x, y] = plane;
        found.push({ mark: joint, x0: low[x], x1: high[x], y0: low[y], y1: high[y] });
        return;
      }
      const middle = 0.5 * (low[joint] + high[joint]), ends = [low[joint], high[joint]];
      const free = plane.includes(joint);
      high[joint] = middle;
      if (free || q[joint] <= middle) visit();
      else skip();
      [low[joint], high[joint]] = [middle, ends[1]];
      if (free || q[joint] > middle) visit();
      else skip();
      [low[joint], high[joint]] = ends;
    };
    visit();
    return found;
  };

  // What holds of a box in two branches: proven where both are, refuted where one is.
  const both = (a, b) => (a === REFUTED || b === REFUTED ? REFUTED : a === PROVEN && b === PROVEN ? PROVEN : OPEN);

  class ProvenCells {
    constructor({ records, scale }, lower, upper) {
      const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
      Object.assign(this, { records: records.map(bytes), scale, lower, upper });
    }

    // {mark, x0, x1, y0, y1}, which together are the plane.
    meeting(plane, q) {
      return this.records.map((record) => ofBranch(record, this.lower, this.upper, q, plane)).reduce((all, own) => (
        all.flatMap((a) => own.flatMap((b) => {
          const cut = { mark: both(a.mark, b.mark), x0: Math.max(a.x0, b.x0), x1: Math.min(a.x1, b.x1), y0: Math.max(a.y0, b.y0), y1: Math.min(a.y1, b.y1) };
          return cut.x0 < cut.x1 && cut.y0 < cut.y1 ? [cut] : [];
        }))
      ));
    }
  }

  return { ProvenCells, PROVEN, REFUTED, OPEN };
})();
