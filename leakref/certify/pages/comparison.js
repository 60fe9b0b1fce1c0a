// Sorts the codes and hides what was not asked for. Without it the page holds the same, in the order of the names.
"use strict";
(() => {
  const all = (what, where = document) => [...where.querySelectorAll(what)];
  const by = (id) => document.getElementById(id);
  const text = new Map(all(".one, .row, .head").map((one) => [one, one.textContent.toLowerCase()]));
  const names = new Map(all(".head").map((one) => [one.dataset.code, one.querySelector("h3").textContent.toLowerCase()]));

  const show = () => {
    const words = by("words").value.trim().toLowerCase(), family = by("family").value, only = by("differs").checked;
    const found = new Set(), any = words || family || only;  // what was not asked has no finding: it is seen where all is
    const empty = (part) => any && all(".one, .row", part).every((one) => one.hidden);
    let shown = 0;
    for (const section of all(".family")) {
      const inside = !family || section.dataset.family === family;
      for (const one of all(".one, .row", section)) {
        const code = one.dataset.code, said = text.get(one) + " " + (names.get(code) || "");
        one.hidden = !inside || (only && !("differs" in one.dataset)) || !said.includes(words);
        if (!one.hidden && code) { shown++; found.add(code); }
      }
      for (const part of all(".fold, .part, .group", section)) part.hidden = empty(part);
      section.hidden = empty(section);
    }
    for (const one of all(".head, #overview tbody tr")) {
      const code = one.dataset.code, head = by("code-" + code);
      one.hidden = words !== "" && !found.has(code) && !text.get(head).includes(words);
    }
    for (const cell of all("#overview [data-family]")) cell.hidden = family !== "" && cell.dataset.family !== family;
    by("shown").textContent = shown + " of " + all(".one").length + " findings shown";
  };

  const sort = (key, down) => {
    const body = by("overview").tBodies[0];
    const value = (row, name) => Number(row.dataset[name]);
    all("tr", body).sort((a, b) => (down ? -1 : 1) * (value(a, key) - value(b, key)) || value(a, "name") - value(b, "name"))
      .forEach((row) => { body.append(row); by("code-" + row.dataset.code).parentNode.append(by("code-" + row.dataset.code)); });
    for (const head of all("th[data-sort]")) head.removeAttribute("aria-sort");
    document.querySelector(`th[data-sort="${key}"]`).setAttribute("aria-sort", down ? "descending" : "ascending");
    by("order").value = key;
  };

  for (const head of all("th[data-sort]")) {
    const button = document.createElement("button");
    button.textContent = head.textContent;
    head.replaceChildren(button);
    button.addEventListener("click", () => sort(head.dataset.sort, head.getAttribute("aria-sort") === "ascending"));
  }
  by("order").addEventListener("change", () => sort(by("order").value, false));
  for (const id of ["words", "family", "differs"]) by(id).addEventListener("input", show);

  const open = () => {  // a finding that is linked to may be folded away, or hidden
    const one = by(location.hash.slice(1));
    if (!one) return;
    if (one.closest("[hidden]")) { by("words").value = by("family").value = ""; by("differs").checked = false; show(); }
    for (let fold = one.closest("details"); fold; fold = fold.parentElement.closest("details")) fold.open = true;
    one.scrollIntoView();
  };
  addEventListener("hashchange", open);
  document.querySelector(".bar").hidden = false;
  sort("name", false);
  show();
  open();
})();
