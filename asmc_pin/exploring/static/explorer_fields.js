// Sliders and fields of the explorer: what a person moves, in degrees and millimetres, and M̄ and the loop's gains.
"use strict";
const AsmcFields = (() => {
  // A child element; its text is never read as HTML.
  const element = (parent, tag, attributes = {}, text = "") => {
    const made = document.createElement(tag);
    for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
    made.textContent = text;
    parent.append(made);
    return made;
  };

  // A name that may be broken after its underscores.
  const named = (parent, tag, attributes, name) => {
    const made = element(parent, tag, attributes);
    for (const part of name.split(/(?<=[_./-])/)) made.append(part, document.createElement("wbr"));
    return made;
  };

  const figure = (value, digits = 5) => (Number.isFinite(value) ? String(Number(value.toPrecision(digits))) : "—").replace("-", "−");

  // One joint's angle or place for a person.
  class Place {
    constructor({ prismatic }) { Object.assign(this, prismatic ? { factor: 1000, unit: "mm" } : { factor: 180 / Math.PI, unit: "°" }); }

    shown(value) { return Number((this.factor * value).toFixed(2)) + 0; }

    words(value) { return `${String(this.shown(value)).replace("-", "−")}${this.unit === "°" ? "°" : " mm"}`; }
  }

  class JointFields {
    // `moved(joint, value)` is told of a slider or field that a person moves, in rad or m.
    constructor(host, joints, moved) {
      this.places = joints.map((joint) => new Place(joint));
      this.rows = joints.map((joint, k) => {
        const place = this.places[k], row = element(host, "div", { class: "joint" });
        named(row, "label", { for: `place-${k}` }, joint.name);
        const slider = element(row, "input", {
          type: "range", min: place.factor * joint.lower, max: place.factor * joint.upper, step: "any", "aria-label": joint.name,
        });
        const field = element(row, "input", { type: "number", id: `place-${k}`, step: "any", inputmode: "decimal" });
        element(row, "span", { class: "unit" }, place.unit);
        if (joint.idle) row.title = "The norm does not depend on this joint: it moves its branch as a whole.";
        slider.addEventListener("input", () => moved(k, Number(slider.value) / place.factor));
        field.addEventListener("change", () => {
          if (field.value !== "" && Number.isFinite(Number(field.value))) moved(k, Number(field.value) / place.factor);
        });
        return { slider, field };
      });
    }

    show(q) {
      this.rows.forEach(({ slider, field }, k) => {
        const place = this.places[k];
        slider.value = place.factor * q[k];
        slider.setAttribute("aria-valuetext", place.words(q[k]));
        field.value = place.shown(q[k]);
      });
    }
  }

  // Numbers above zero with names; what is no such number is said and not taken.
  class PositiveFields {
    constructor(host, items, values, changed) {
      this.fields = items.map(({ name, unit, id }, k) => {
        const row = element(host, "div", { class: "number" });
        named(row, "label", { for: id }, name);
        const field = element(row, "input", { type: "number", id, step: "any", min: 0, inputmode: "decimal" });
        element(row, "span", { class: "unit" }, unit);
        field.addEventListener("input", () => {
          const value = Number(field.value), good = field.value !== "" && value > 0 && Number.isFinite(value);
          field.setAttribute("aria-invalid", String(!good));
          if (good) changed(k, value);
        });
        return field;
      });
      this.show(values);
    }

    // A field that a person is writing in keeps what stands in it, but for a reset.
    show(values, all = true) {
      this.fields.forEach((field, k) => {
        if (!all && field === document.activeElement) return;
        field.value = Number(values[k].toPrecision(8));
        field.setAttribute("aria-invalid", "false");
      });
    }
  }

  return { element, named, figure, Place, JointFields, PositiveFields };
})();
