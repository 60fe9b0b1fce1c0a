"""The page of a certificate in Chromium: it renders, in a wide and in a narrow frame, open as well as closed."""

from __future__ import annotations

from base64 import b64encode
from dataclasses import replace
from io import BytesIO

import numpy as np
import pytest
from browser import WIDTHS, look
from matplotlib.image import imsave
from test_report import HOSTILE, certificate

from leakref.certify.report import page


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
