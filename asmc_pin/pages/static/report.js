// What a report does besides the replay and the figures: the legend, hints on wide tables, and paper.
"use strict";
(() => {
  // A controller is hidden everywhere at once: curves, scene, tables, cards.
  for (const button of document.querySelectorAll(".legend button")) {
    button.addEventListener("click", () => {
      const on = button.getAttribute("aria-pressed") !== "true", { label } = button.dataset;
      button.setAttribute("aria-pressed", String(on));
      for (const item of document.querySelectorAll("[data-controller]")) if (item.dataset.controller === label) item.hidden = !on;
      document.dispatchEvent(new CustomEvent("controller-shown", { detail: { label, on } }));
    });
  }

  // A table that goes on to the right says so.
  const wide = [...document.querySelectorAll(".scroll")];
  const look = (box) => box.classList.toggle("has-more", box.scrollLeft + box.clientWidth < box.scrollWidth - 4);
  const watch = new ResizeObserver((entries) => { for (const { target } of entries) look(target); });
  for (const box of wide) {
    watch.observe(box);
    box.addEventListener("scroll", () => look(box), { passive: true });
  }
  document.addEventListener("toggle", () => wide.forEach(look), true);

  // On paper everything is open.
  let opened = [];
  const paper = () => {
    opened = [...document.querySelectorAll("details:not([open])")];
    for (const fold of opened) fold.open = true;
  };
  addEventListener("beforeprint", paper);
  addEventListener("afterprint", () => { for (const fold of opened) fold.open = false; });
})();
