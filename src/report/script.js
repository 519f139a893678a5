// A point tells what it is under its chart on a click, a tap or the focus of a keyboard: touch screens show no titles.
"use strict";
for (const figure of document.querySelectorAll("figure")) {
  const told = figure.querySelector(".told");
  if (!told) continue;
  const tell = (event) => {
    const point = event.target.closest(".p") ?? event.target.querySelector(":scope > .p");
    if (!point) return;
    for (const other of figure.querySelectorAll(".p.on")) other.classList.remove("on");
    point.classList.add("on");
    told.textContent = point.querySelector("title").textContent;
    told.hidden = false;
  };
  figure.addEventListener("click", tell);
  figure.addEventListener("focusin", tell);
}
