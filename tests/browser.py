"""What is seen of a page in Chromium: run on a file, and looked at in a frame of some width."""

from __future__ import annotations

import json
import re
from html import escape, unescape

WIDTHS = (1280, 390)
# What is seen: the rectangles of all text and pictures, those that overlap, and those that stick out of the window.
LOOK = r"""
<script>
const alerts = []; window.alert = (said) => alerts.push(String(said));
addEventListener("load", () => {
  const seen = (open) => {
    document.querySelectorAll("details").forEach((one) => { one.open = open; });
    const boxes = [];
    const add = (rectangles, what, inside) => { for (const r of rectangles) if (r.width > 1 && r.height > 1)
      boxes.push({left: r.left, right: r.right, top: r.top, bottom: r.bottom, what, inside}); };
    const walk = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
    for (let node; (node = walk.nextNode()); ) {
      const parent = node.parentElement;
      if (!node.data.trim() || parent.closest("script") || !parent.checkVisibility()) continue;
      const range = document.createRange(); range.selectNodeContents(node);
      add(range.getClientRects(), node.data.trim().slice(0, 60), parent.closest("svg") || parent.closest(".wide"));
    }
    document.querySelectorAll("img, svg").forEach((one) => {
      if (one.checkVisibility()) add([one.getBoundingClientRect()], one.tagName, one); });
    boxes.sort((a, b) => a.top - b.top);
    const overlaps = [], outside = [];
    boxes.forEach((a, n) => {
      for (let m = n + 1; m < boxes.length && boxes[m].top < a.bottom - 2; m++) {
        const b = boxes[m];
        if ((a.inside && a.inside === b.inside) && (a.what === "svg" || b.what === "svg")) continue;
        if (Math.min(a.right, b.right) - Math.max(a.left, b.left) > 2) overlaps.push([a.what, b.what]);
      }
      const frame = a.inside && a.inside.tagName === "svg" && a.what !== "svg" ? a.inside.getBoundingClientRect()
        : {left: 0, right: document.documentElement.clientWidth};
      const scrolls = a.inside && a.inside.tagName === "DIV";
      if (!scrolls && (a.left < frame.left - 1 || a.right > frame.right + 1)) outside.push(a.what);
    });
    return {boxes: boxes.length, overlaps: overlaps.slice(0, 5), outside: outside.slice(0, 5),
            wide: document.documentElement.scrollWidth - document.documentElement.clientWidth};
  };
  const found = {width: innerWidth, closed: seen(false), open: seen(true), alerts, scripts: document.scripts.length,
                 details: document.querySelectorAll("details").length,
                 pictures: [...document.images].map((one) => one.naturalWidth)};
  const said = document.createElement("pre"); said.id = "seen"; said.textContent = JSON.stringify(found);
  parent.document.body.append(said);
});
</script>
"""


def look(chromium, path, text, width):
    """What is seen of a page in a frame of some width, and what it said on the console."""
    watched = escape(text.replace("<head>", "<head>" + LOOK, 1))  # windows are never narrower than 500 pixels
    path.write_text(
        f'<!doctype html><meta charset="utf-8"><iframe width="{width}" height="900" style="border: 0" '
        f'srcdoc="{watched}"></iframe>',
        encoding="utf-8",
    )
    dom, console = chromium(path, "--dump-dom", "--window-size=1400,950", "--virtual-time-budget=5000")
    return json.loads(unescape(re.findall(r'<pre id="seen">(.*?)</pre>', dom, re.DOTALL)[-1])), console
