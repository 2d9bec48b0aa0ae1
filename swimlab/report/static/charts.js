"use strict";
// The charts: reading a mark by mouse, touch or keys, showing only some techniques, and picking one for the maps.
{
  const charts = document.getElementById("charts");

  // ---- reading

  const marks = (svg) => [...svg.querySelectorAll("title")].map((title) => title.parentElement)
    .filter((mark) => !mark.closest(".out"));

  function say(figure, mark) {
    figure.querySelector(".read")?.classList.remove("read");
    mark?.classList.add("read");
    figure.querySelector(".says").textContent = mark ? mark.querySelector("title").textContent : "";
  }

  function step(svg, by) {
    const all = marks(svg);
    const at = all.findIndex((mark) => mark.classList.contains("read"));
    if (all.length) say(svg.closest("figure"), all[at < 0 ? (by > 0 ? 0 : all.length - 1) : (at + by + all.length) % all.length]);
  }

  for (const svg of charts.querySelectorAll("figure > svg")) {
    if (!svg.querySelector("title")) continue;
    svg.tabIndex = 0;
    const read = (event) => {
      const mark = event.target.querySelector(":scope > title") && event.target;
      if (mark && mark !== svg && !mark.closest(".out")) say(svg.closest("figure"), mark);
    };
    svg.addEventListener("pointerover", read);
    svg.addEventListener("click", read);
    svg.addEventListener("keydown", (event) => {
      const by = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 }[event.key];
      if (!by && event.key !== "Escape") return;
      if (by) step(svg, by);
      else say(svg.closest("figure"), null);
      event.preventDefault();
      event.stopPropagation();
    });
  }

  // ---- showing only some

  const chosen = new Set();
  const named = [...charts.querySelectorAll("g[data-name]")];
  const buttons = [...charts.querySelectorAll("button[data-name]")];

  function show() {
    const has = new Set(named.filter((group) => chosen.has(group.dataset.name)).map((group) => group.closest("svg")));
    for (const group of named) group.classList.toggle("out", has.has(group.closest("svg")) && !chosen.has(group.dataset.name));
    for (const button of buttons) button.setAttribute("aria-pressed", chosen.has(button.dataset.name));
  }

  function emphasise(figure, name) {
    for (const group of figure.querySelectorAll("g[data-name]")) group.classList.toggle("faint", Boolean(name) && group.dataset.name !== name);
  }

  for (const button of buttons) {
    const figure = button.closest("figure");
    button.addEventListener("click", () => {
      if (!chosen.delete(button.dataset.name)) chosen.add(button.dataset.name);
      show();
    });
    for (const [start, end] of [["pointerenter", "pointerleave"], ["focus", "blur"]]) {
      button.addEventListener(start, () => emphasise(figure, button.dataset.name));
      button.addEventListener(end, () => emphasise(figure, ""));
    }
  }

  // ---- one technique at a time

  for (const select of charts.querySelectorAll("select.technique")) {
    select.addEventListener("change", () => {
      for (const part of select.closest(".maps").querySelectorAll("[data-technique]")) part.hidden = part.dataset.technique !== select.value;
    });
    select.addEventListener("keydown", (event) => event.stopPropagation());
  }
}
