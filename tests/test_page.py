"""The page of a certificate in Chromium: it renders, in a wide and in a narrow frame, open as well as closed."""

from __future__ import annotations

import json
import re
import subprocess
from base64 import b64encode
from dataclasses import replace
from html import escape, unescape
from io import BytesIO

import numpy as np
import pytest
from matplotlib.image import imsave
from test_report import HOSTILE, certificate
from tools import requires

from leakref.certify.report import page

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


@pytest.fixture(scope="module")
def chromium(tmp_path_factory):
    """A function that runs Chromium on a file, as a new user: what it printed and what it logged."""
    program = requires("chromium")

    def run(path, *arguments):
        done = subprocess.run(
            [
                program,
                "--headless",
                "--no-sandbox",
                "--disable-gpu",
                "--no-first-run",
                "--disable-background-networking",
                "--disable-dev-shm-usage",
                "--hide-scrollbars",
                f"--user-data-dir={tmp_path_factory.mktemp('user')}",
                "--enable-logging=stderr",
                *arguments,
                path.as_uri(),
            ],
            capture_output=True,
            text=True,
            timeout=120,
        )
        assert done.returncode == 0, done.stderr
        return done.stdout, [line for line in done.stderr.splitlines() if "CONSOLE" in line]

    return run


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


@pytest.fixture(scope="module")
def large():
    """A page of 300 findings, everything on it hostile."""
    found, picture = certificate(), BytesIO()
    imsave(picture, np.eye(60, 1024), format="png")
    findings = (list(found.findings) * 40)[:300]
    return page(
        replace(found, findings=findings),
        [{"title": HOSTILE, "words": HOSTILE, "data": b64encode(picture.getvalue()).decode()}],
    )


@pytest.mark.parametrize("width", WIDTHS)
def test_nothing_overlaps_or_sticks_out_and_nothing_hostile_runs(chromium, large, tmp_path, width):
    assert len(large.encode()) < 5e6
    seen, console = look(chromium, tmp_path / f"{width}.html", large, width)
    assert console == []
    assert seen["width"] == width
    assert (seen["alerts"], seen["scripts"], seen["details"]) == ([], 1, 300)  # the one script is the one that looks
    assert seen["pictures"] == [1024]
    for state in ("closed", "open"):
        assert (seen[state]["overlaps"], seen[state]["outside"], seen[state]["wide"]) == ([], [], 0), state
    assert seen["open"]["boxes"] > seen["closed"]["boxes"] + 3000


@pytest.mark.parametrize(
    ("planted", "part", "what"),
    [
        ('<p style="position: absolute; top: 40px">planted</p>', "overlaps", "planted"),
        ('<p style="white-space: nowrap">' + "planted " * 200 + "</p>", "outside", "planted"),
        ('<svg width="50" height="20"><text x="30" y="15">planted</text></svg>', "outside", "planted"),
    ],
)
def test_the_look_out_sees_what_it_is_there_for(chromium, tmp_path, planted, part, what):
    text = page(certificate()).replace("</h1>", "</h1>" + planted, 1)
    seen, _ = look(chromium, tmp_path / "planted.html", text, 390)
    assert what in str(seen["open"][part])


def test_the_look_out_sees_scripts_that_run_and_errors_on_the_console(chromium, tmp_path):
    text = page(certificate()).replace("</h1>", "</h1><script>alert(1); console.error('planted')</script>", 1)
    seen, console = look(chromium, tmp_path / "planted.html", text, 1280)
    assert (seen["alerts"], seen["scripts"]) == (["1"], 2)
    assert "planted" in str(console)


def test_it_prints(chromium, large, tmp_path):
    (tmp_path / "page.html").write_text(large, encoding="utf-8")
    chromium(tmp_path / "page.html", f"--print-to-pdf={tmp_path / 'page.pdf'}", "--no-pdf-header-footer")
    assert (tmp_path / "page.pdf").read_bytes().startswith(b"%PDF-")
