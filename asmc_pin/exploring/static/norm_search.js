// The largest norm that a short search of the joint box finds for the M̄ in the fields: the same points every time.
"use strict";
const AsmcSearch = (() => {
  const SAMPLES = 3000, CLIMBS = 6;

  // Numbers in [0, 1) that repeat: Lehmer's generator.
  const numbers = () => {
    let state = 48271;
    return () => { state = (state * 48271) % 2147483647; return state / 2147483647; };
  };

  class NormSearch {
    constructor(lower, upper, normAt) { Object.assign(this, { lower, upper, normAt, run: 0 }); }

    stop() { this.run += 1; }

    // Calls `told({norm, q, count})` once, between frames; `also` are configurations to climb from too.
    begin(mbar, also, told) {
      const run = ++this.run, steps = this.steps(mbar, also);
      const go = () => {
        if (run !== this.run) return;
        for (const until = performance.now() + 12; performance.now() < until;) {
          const { value, done } = steps.next();
          if (done) { told(value); return; }
        }
        setTimeout(go);
      };
      go();
    }

    *steps(mbar, also) {
      const { lower, upper } = this, draw = numbers(), seen = [];
      let count = 0;
      const look = (q) => { count += 1; return { q, norm: this.normAt(q, mbar) }; };
      for (const q of also) seen.push(look(q));
      for (let k = 0; k < SAMPLES; k++) {
        seen.push(look(Float64Array.from(lower, (low, i) => low + draw() * (upper[i] - low))));
        yield;
      }
      seen.sort((a, b) => b.norm - a.norm);
      let best = seen[0];
      for (const start of seen.slice(0, CLIMBS)) {
        let here = start;
        // Joint after joint up and down, by less and less.
        for (let share = 0.1; share > 1e-6;) {
          let better = false;
          for (let i = 0; i < lower.length; i++) {
            for (const way of [-1, 1]) {
              const q = here.q.slice();
              q[i] = Math.min(Math.max(q[i] + way * share * (upper[i] - lower[i]), lower[i]), upper[i]);
              const next = look(q);
              if (next.norm > here.norm) [here, better] = [next, true];
            }
            yield;
          }
          if (!better) share *= 0.4;
        }
        if (here.norm > best.norm) best = here;
      }
      return { ...best, count };
    }
  }

  return { NormSearch };
})();
