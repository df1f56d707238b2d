// Looks at its own address again and again, and shows what changed; a page that reloads loses who reads or listens.
"use strict";
(() => {
  const shown = document.querySelector("main");
  const look = async () => {
    try {
      const text = await (await fetch(location.href, { cache: "no-store" })).text();
      const found = new DOMParser().parseFromString(text, "text/html").querySelector("main.followed");
      if (!found) return location.reload(); // the comparison is whole: its replay stands there now
      if (found.innerHTML !== shown.innerHTML) shown.replaceChildren(...found.childNodes);
      if (found.dataset.ended) return;
    } catch {
      shown.querySelector(".state").textContent = "nobody answers any more: is the command still running?";
    }
    setTimeout(look, 1000 * Number(shown.dataset.every));
  };
  setTimeout(look, 1000 * Number(shown.dataset.every));
})();
