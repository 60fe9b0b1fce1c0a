"""leakref compare: certificates side by side, from files that other people wrote, on a page that is sent to others."""

from __future__ import annotations

import json
import re
from collections import Counter
from contextlib import nullcontext
from dataclasses import replace
from html import unescape
from itertools import permutations

import pytest
from browser import WIDTHS, look
from test_commands import here
from test_report import HOSTILE, Elements

from leakref import LeakrefError, __version__
from leakref.certify.certificate import Certificate
from leakref.certify.comparison import differing, page, read, read_all, unlike
from leakref.certify.runner import certify, select
from leakref.certify.subject.inprocess import InProcess
from leakref.certify.targets import load
from leakref.certify.verdict import Finding, Verdict

SAID = {
    "name": "one",
    "version": "1.0",
    "units": "si",
    "axes": "xyt",
    "y": "up",
    "direction": "to",
    "fixed": [],
    "can": {"extract": {}},
}
LATER = ("grade_line", "coverage", "scope", "seed", "date", "complete", "cut_short")
DATED = {"seed": 7, "date": "2026-11-26T11:00:00+00:00"}


def finding(identifier, verdict="pass", message="as it should be"):
    repro = f"leakref certify mine --only '{identifier}' --keep FOLDER"
    return Finding(identifier, identifier.partition(".")[0], Verdict(verdict), message, None, 0.5, repro, "eq:SnJ")


def record(name="one", own="1.0", verdicts=(), *, message="as it should be", **more):
    """The JSON of a certificate whose findings have these ids and verdicts."""
    found = [finding(identifier, verdict, message) for identifier, verdict in dict(verdicts or EASY).items()]
    made = Certificate("mine", "quick", "v1", {**SAID, "name": name, "version": own}, found)
    return {**made.record(), **more}


def older(*given, **more):
    """As an earlier leakref wrote it."""
    return {name: value for name, value in record(*given, **more).items() if name not in LATER}


def scope(words):
    return {"scope": {**record()["scope"], "words": words}}


EASY = {
    "signs.sea[a]": "pass",
    "signs.sea[b]": "pass",
    "recovery.pair[a]": "pass",
    "synthesis.energy[a]": "pass",
    "conformance.extract[a]": "pass",
}


def write(folder, *records):
    """Files with these certificates; their paths."""
    paths = [folder / f"{n}.json" for n in range(len(records))]
    for path, one in zip(paths, records, strict=True):
        path.write_text(json.dumps(one), encoding="utf-8")
    return paths


def codes(folder, *records):
    return read_all(write(folder, *records))


class Page(Elements):
    """Besides, the ids in a page, and the words that are seen."""

    def __init__(self, text):
        self.ids, self.words, self.inside = [], "", []
        super().__init__(text)

    def handle_starttag(self, tag, attrs):
        super().handle_starttag(tag, attrs)
        self.ids += [value for name, value in attrs if name == "id"]
        self.inside.append(tag)

    def handle_data(self, data):
        if self.inside[-1:] not in (["script"], ["style"]):
            self.words += data

    def handle_endtag(self, tag):
        self.inside.append("/" + tag)


@pytest.fixture(scope="module")
def real(tmp_path_factory):
    """The reference, and it with y flipped, asked for a few; the paths of their certificates."""
    folder = tmp_path_factory.mktemp("real")
    pairs = select(["signs.aligned"], profile="quick")
    right, wrong = (
        certify(target, [nullcontext(InProcess(load(target)))], pairs, profile="quick")
        for target in ("reference", "fault:flipped-y")
    )
    return write(folder, right.record(), replace(wrong, explanation="x and y exchanged").record())


# ---------------------------------------------------------------- wrong input


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (None, "cannot be read (No such file or directory); name a certificate.json that `leakref certify --report`"),
        ("", "is not JSON"),
        ("<html>", "is not JSON"),
        ("\udcff", "is not JSON"),
        ("[" * 100_000, "is not JSON"),
        ("[]", "is no certificate of leakref certify; name"),
        ("{}", "is no certificate of leakref certify; name"),
        ('{"schema": 1}', "is no certificate of leakref certify; name"),
        ('{"schema": "leakref/strength/1"}', "certify: its schema is 'leakref/strength/1'; name"),
        ('{"schema": "leakref/certify/2"}', "of the format leakref/certify/2, and leakref/certify/1 is what is read"),
        ('{"schema": "leakref/certify/2", "version": "9"}', "or compare with leakref 9, which made it"),
        ('{"schema": "leakref/certify/1", "ids": []}', "is damaged: it: 'version' is a required property; certify"),
    ],
)
def test_a_file_that_is_no_certificate_is_refused_by_name(text, said, tmp_path):
    (good,) = write(tmp_path, record())
    bad = tmp_path / "bad.json"
    if text is not None:
        bad.write_text(text, encoding="utf-8", errors="surrogateescape")
    done = here("compare", good, bad, "--out", tmp_path / "out")
    assert done.returncode == 2
    assert done.stderr.startswith(f"leakref: compare: {bad} ")
    assert done.stderr.count("\n") == 1
    assert said in done.stderr
    assert not (tmp_path / "out").exists()


def changed(**more):
    return {**record(), **more}


@pytest.mark.parametrize(
    ("damaged", "said"),
    [
        (changed(grade="excellent"), "grade: 'excellent' is not one of"),
        (changed(findings={}), "findings: {} is not of type 'array'"),
        (changed(findings=[None]), "findings[0]: None is not of type 'object'"),
        (changed(findings=[{"id": "signs.sea[a]"}]), "findings[0]: 'family' is a required property"),
        (changed(findings=[{**finding("signs.sea[a]").record(), "verdict": "maybe"}]), "findings[0].verdict: 'maybe'"),
        (changed(findings=[{**finding("signs.sea[a]").record(), "message": 3}]), "findings[0].message: 3 is not"),
        (changed(findings=[{**finding("signs.sea[a]").record(), "id": "sea"}]), "findings[0].id: 'sea' does not"),
        (changed(findings=[{**finding("signs.sea[a]").record(), "family": "shear"}]), "said to be of the family shear"),
        (changed(findings=[finding("signs.sea[a]").record()] * 2), "the finding signs.sea[a] is there twice"),
        (changed(findings=[]), "its counts are not those of its 0 findings"),
        (changed(counts={"pass": 4, "fail": 1}), "its counts are not those of its 5 findings"),
        (changed(declaration={**SAID, "name": ["one"]}), "declaration.name: ['one'] is not of type 'string'"),
        (changed(coverage={"asked": 5}), "coverage: 'judged' is a required property"),
        (changed(**scope(1)), "scope.words: 1 is not of type 'string'"),
        (changed(seed="one"), "seed: 'one' is not of type"),
        (changed(known=[{"id": "signs.sea[a]", "reason": 1, "issue": "", "stale": False}]), "known[0].reason: 1 is"),
        (changed(version="0.0.1", grade=1), "or compare with leakref 0.0.1, which made it"),
    ],
)
def test_a_certificate_that_is_damaged_is_refused_with_what_is_wrong(damaged, said, tmp_path):
    good, bad = write(tmp_path, record(), damaged)
    with pytest.raises(LeakrefError) as refused:
        read_all([good, bad])
    assert str(refused.value).startswith(f"compare: {bad} is damaged: ")
    assert said in str(refused.value)
    assert ("or compare with leakref" in str(refused.value)) is (damaged["version"] != __version__)


def test_one_alone_has_nothing_beside_it(tmp_path):
    (path,) = write(tmp_path, record())
    for paths in ([], [path]):
        with pytest.raises(
            LeakrefError, match=r"certificate was given, and one has nothing beside it; name two or mor"
        ):
            read_all(paths)
    assert here("compare", path, "--out", tmp_path).returncode == 2
    assert here("compare", path, path).returncode == 2  # no --out


def test_a_folder_and_a_place_where_nothing_can_be_written_are_refused(tmp_path):
    paths = write(tmp_path, record(), record("two"))
    with pytest.raises(LeakrefError, match=r"cannot be read \(Is a directory\)"):
        read(tmp_path)
    (tmp_path / "file").touch()
    done = here("compare", *paths, "--out", tmp_path / "file" / "x")
    assert (done.returncode, done.stdout) == (2, "")


def test_what_a_shell_of_windows_redirects_is_read(tmp_path):
    path = tmp_path / "certificate.json"
    for encoding in ("utf-16", "utf-8-sig"):
        path.write_text(json.dumps(record()), encoding=encoding)
        assert read(path).name == "one"


# ---------------------------------------------------------------- what is compared


def test_a_planted_disagreement_is_seen(real, tmp_path):
    done = here("compare", *real, "--out", tmp_path, "--json")
    assert done.returncode == 0, done.stderr
    printed = json.loads(done.stdout)
    ids = [f"{check.id}[{case.id}]" for check, case in select(["signs.aligned"], profile="quick")]
    assert printed["differs"] == ids
    text = (tmp_path / "comparison.html").read_text(encoding="utf-8")
    seen = Page(text)
    assert f"Verdicts differ in {len(ids)} of {len(ids)} questions." in seen.words
    assert f"{len(ids)} of {len(ids)} wrong" in seen.words
    assert f"all {len(ids)} held" in seen.words
    assert "x and y exchanged" in seen.words
    one, other = (json.loads(path.read_text(encoding="utf-8")) for path in real)
    for f in [*one["findings"], *other["findings"]]:
        assert {f["id"], f["repro"]} <= set(re.findall(r'(?:class="id">|<pre>)([^<]*)<', unescape(text)))
        assert f["message"] in seen.words
    same = codes(tmp_path, one, one)
    assert differing(same) == []
    assert "No verdict differs between them." in page(same)


def test_json_has_what_the_protocol_says(real, tmp_path):
    done = here("compare", *reversed(real), "--out", tmp_path / "deep" / "out", "--json")
    printed = json.loads(done.stdout)
    assert (printed["schema"], printed["ok"], printed["version"]) == ("leakref/compare/1", True, __version__)
    assert printed["path"] == str(tmp_path / "deep" / "out" / "comparison.html")
    rows = {row["target"]: row for row in printed["codes"]}
    assert list(rows) == ["fault:flipped-y", "reference"]
    wrong = rows["fault:flipped-y"]
    assert set(wrong) == {"name", "version", "target", "grade", "wrong", "coverage"}
    assert (wrong["grade"], wrong["wrong"]) == ("rejected", len(printed["differs"]))
    assert (rows["reference"]["grade"], rows["reference"]["wrong"]) == ("sound", 0)
    assert wrong["coverage"] == {"asked": wrong["wrong"], "judged": wrong["wrong"], "missing": 0, "unsupported": 0}
    assert printed["unlike"] == []


def test_on_a_terminal_there_is_a_table_and_the_place_of_the_page(tmp_path):
    half = {**EASY, "signs.sea[a]": "fail", "recovery.pair[a]": "missing", "synthesis.energy[a]": "unsupported"}
    paths = write(tmp_path, record("one[/]", verdicts=half), record("two", verdicts={"signs.sea[a]": "pass"}))
    done = here("compare", *paths, "--out", tmp_path)
    assert done.returncode == 0
    said = " ".join(done.stdout.split())
    for row in (
        "family ┃ one[/] 1.0 ┃ two 1.0",
        "signs │ 1 of 2 wrong │ held",
        "recovery │ 1 of 1 missing │ not asked",
    ):
        assert row in said
    assert "synthesis │ not offered │ not asked" in said
    assert "Mind: Not asked the same questions: 1 for two 1.0; 5 for one[/] 1.0; 1 of 5 were asked of all." in said
    assert f"Findings that differ between codes: 1. Page: {tmp_path / 'comparison.html'}" in done.stdout


def test_the_order_of_the_files_is_of_no_matter(tmp_path):
    three = [record("b"), record("A", verdicts={**EASY, "signs.sea[a]": "fail"}), record("b", explanation="other")]
    paths = write(tmp_path, *three)
    assert len({page(read_all(order)) for order in permutations(paths)}) == 1
    assert [code.label for code in read_all(paths)] == ["A 1.0", "b 1.0 (1)", "b 1.0 (2)"]


def test_codes_of_one_name_are_numbered_where_their_version_is_the_same_too(tmp_path):
    found = codes(tmp_path, record(own="1.0"), record(own="1.1"), record(own="1.1"), record("", ""))
    assert [code.label for code in found] == ["mine", "one 1.0", "one 1.1 (1)", "one 1.1 (2)"]


def test_cells_say_what_happened(tmp_path):
    verdicts = {
        **EASY,
        "signs.sea[a]": "fail",
        "signs.sea[b]": "missing",
        "recovery.pair[a]": "timeout",
        "synthesis.energy[a]": "unsupported",
    }
    first, second = codes(tmp_path, record("1", verdicts=verdicts), record("2", verdicts={"signs.sea[a]": "pass"}))
    cells = {family: first.cell(family) for family in ("signs", "recovery", "synthesis", "conformance", "shear")}
    assert {family: cell.words for family, cell in cells.items()} == {
        "signs": "1 of 1 wrong",
        "recovery": "1 of 1 wrong",
        "synthesis": "not offered",
        "conformance": "held",
        "shear": "not asked",
    }
    assert cells["signs"].besides == ["1 missing"]
    assert second.cell("signs", ["signs.sea[a]", "signs.sea[b]"]).besides == ["1 not asked"]
    assert differing([first, second]) == ["signs.sea[a]"]
    assert (first.grade_line, first.coverage) == (
        "rejected, 3 of 5 questions",
        {"asked": 5, "judged": 3, "missing": 1, "unsupported": 1},
    )


def test_an_older_certificate_is_read_and_counted_here(tmp_path):
    some = {**EASY, "signs.sea[b]": "missing", "synthesis.energy[a]": "unsupported"}
    given = record("newer", verdicts=some, **DATED, **scope("Deep water, waves of 1 to 30 m."))
    newer, old = codes(tmp_path, given, older("older", verdicts=some))
    seen = Page(page([newer, old])).words
    for words in ("sound, 3 of 5 questions", "Deep water, waves of 1 to 30 m.", "seed 7", "2026-11-26, 11:00 UTC"):
        assert words in seen
    assert (old.scope, old.date, old.setting("seed")) == ("not said",) * 3
    assert old.coverage == newer.coverage == {"asked": 5, "judged": 3, "missing": 1, "unsupported": 1}
    assert old.grade_line == newer.grade_line == "sound, 3 of 5 questions"
    assert unlike([newer, old]) == [
        "Shown seas of different seeds: 7 for newer 1.0; not said for older 1.0. "
        "Digits differ for that alone, and a verdict near its tolerance may."
    ]
    pair = codes(tmp_path, older("one"), older("two"))
    assert f"leakref {__version__}, golden set v1, quick profile.</p>" in page(pair)


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ({"version": "9.9"}, f"Made by different versions of leakref: 9.9 for two 1.0; {__version__} for the others."),
        ({"profile": "full"}, "Asked in different profiles: full for two 1.0; quick for the others."),
        ({"golden": "v2"}, "Held against different golden sets: v2 for two 1.0; v1 for the others."),
        ({"seed": 7}, "Shown seas of different seeds: 7 for two 1.0; 1 for the others."),
        ({"cut_short": "by Ctrl-C"}, "The run of two 1.0 was cut short: by Ctrl-C."),
        ({"complete": False}, "The run of two 1.0 was cut short: not said."),
        (
            {"findings": [], "counts": {}, "grade": None},
            "0 for two 1.0; 5 for the others; none of 5 were asked of all.",
        ),
    ],
)
def test_what_was_not_the_same_is_said_at_the_top(more, said, tmp_path):
    alike = codes(tmp_path, record("one"), record("three"))
    assert unlike(alike) == []
    assert f"All were asked the same 5 questions: leakref {__version__}, golden set v1" in page(alike)
    found = codes(tmp_path, record("one"), record("two", **more), record("three"))
    (sentence,) = unlike(found)
    assert said in sentence
    words = Page(page(found)).words
    assert words.index("Not everything here can be compared.") < words.index(said) < words.index("The codes")
    assert "All were asked the same" not in words


# ---------------------------------------------------------------- the page


def hostile(**more):
    known = [{"id": "signs.sea[a]", "reason": HOSTILE, "issue": HOSTILE, "stale": False}]
    words = {"explanation": HOSTILE, "cut_short": HOSTILE, "grade_line": HOSTILE, "date": HOSTILE, "target": HOSTILE}
    verdicts = {
        "signs.sea[a]": "fail",
        "signs.sea[<script>alert(1)</script>]": "error",
        "signs.sea[b]": "pass",
        "recovery.pair[a]": "missing",
        "shear.band[a]": "unsupported",
    }
    made = record(HOSTILE, HOSTILE, verdicts, message=HOSTILE, known=known, **scope(HOSTILE), **words)
    for f in made["findings"]:
        f["repro"] = HOSTILE
    return made | more


def test_hostile_words_are_text_and_nothing_comes_from_elsewhere(tmp_path):
    text = page(codes(tmp_path, hostile(), hostile(version=HOSTILE)))
    seen = Page(text)
    assert Counter(seen.tags)["script"] == 1  # ours
    assert all(reference.startswith("#") for reference in seen.references)
    assert not re.search(r"https?:|url\(|@import", text)
    assert "alert(1)" not in re.search(r"<script>(.*?)</script>", text, re.DOTALL)[1]
    assert text.count("&lt;script&gt;") > 40
    assert seen.words.count("{{ 7 * 7 }}") > 20  # nothing is evaluated twice


def test_characters_that_are_not_shown_are_marked(tmp_path):
    (path,) = write(tmp_path, hostile(target="a\u202eb\ud800c\x1b[31m\nd"))
    assert read(path).record["target"] == "a\ufffdb\ufffdc\ufffd[31m d"
    page(read_all([path, path])).encode()


def test_links_lead_to_what_is_in_the_page(tmp_path):
    some = {**EASY, "signs.sea[b]": "fail", "conformance.extract[a]": "unsupported"}
    found = codes(
        tmp_path, hostile(), record(), record("two", verdicts=some), record("x", verdicts={"shear.b[a]": "pass"})
    )
    seen = Page(page(found))
    assert max(Counter(seen.ids).values()) == 1
    assert {reference.removeprefix("#") for reference in seen.references} <= set(seen.ids)
    linked = Counter(seen.references)
    for number, code in enumerate(found, start=1):
        assert linked[f"#code-{number}"] == 1
        for family in {f["family"] for f in code.record["findings"]}:
            assert linked[f"#{family}-{number}"] == 1
    assert not any(name.startswith("#shear-1-") for name in seen.references if name.endswith("[a]"))
    assert Counter(seen.tags)["pre"] == sum(len(code.record["findings"]) for code in found)


def test_nothing_is_a_share_or_a_score(tmp_path):
    words = Page(page(codes(tmp_path, record(), record("two", verdicts={**EASY, "signs.sea[a]": "fail"})))).words
    assert "%" not in words
    assert not re.search(r"\b(score|rank|best|worst)", words)


def test_without_its_script_it_holds_everything(tmp_path):
    found = codes(tmp_path, record(), hostile(), record("two", verdicts={**EASY, "signs.sea[a]": "fail"}, **DATED))
    text = page(found)
    still = Page(re.sub(r"<script>.*?</script>", "", text, flags=re.DOTALL))
    assert still.words == Page(text).words
    assert re.findall(r"<(\w+)[^>]* hidden>", text) == ["div"]  # what only the script can do
    for code in found:
        for f in code.record["findings"]:
            assert {f["message"], f["repro"], f["id"]} <= {*re.findall(r">([^<>]+)<", text)} | {
                unescape(words) for words in re.findall(r">([^<>]+)<", text)
            }


def test_what_differs_only_in_what_is_offered_is_set_apart(tmp_path):
    some = {
        **EASY,
        "signs.sea[a]": "fail",
        "synthesis.energy[a]": "unsupported",
        "conformance.extract[a]": "unsupported",
    }
    words = Page(page(codes(tmp_path, record(), record("two", verdicts=some)))).words
    assert "Verdicts differ in 3 of 5 questions, in 2 of these only because not every code offers an answer." in words
    assert words.count("1 differs only in that not all codes offer it") == 2
    assert "1 of 2 came out differently" in words


def test_failures_that_break_differently_differ(tmp_path):
    pair = codes(tmp_path, record(verdicts={"signs.a[b]": "fail"}), record("two", verdicts={"signs.a[b]": "error"}))
    assert differing(pair) == ["signs.a[b]"]
    assert "1 of 1 came out differently" in Page(page(pair)).words


# ---------------------------------------------------------------- in Chromium


@pytest.fixture(scope="module")
def mixed(tmp_path_factory, real):
    """Four codes of all kinds, one of them hostile, as a page."""
    folder = tmp_path_factory.mktemp("mixed")
    some = {**EASY, "signs.sea[b]": "missing", "synthesis.energy[a]": "unsupported"}
    records = [hostile(), record("two", verdicts=some, **DATED), *(json.loads(path.read_text()) for path in real)]
    return page(codes(folder, *records))


@pytest.mark.parametrize("width", WIDTHS)
def test_nothing_overlaps_or_sticks_out_and_nothing_hostile_runs(chromium, mixed, tmp_path, width):
    seen, console = look(chromium, tmp_path / f"{width}.html", mixed, width)
    assert console == []
    assert (seen["alerts"], seen["scripts"]) == ([], 2)  # its own, and the one that looks
    for state in ("closed", "open"):
        assert (seen[state]["overlaps"], seen[state]["outside"], seen[state]["wide"]) == ([], [], 0), state


DO = """
<script>
addEventListener("load", () => {
  const by = (id) => document.getElementById(id), all = (what) => [...document.querySelectorAll(what)];
  const set = (id, name, value, event) => { by(id)[name] = value; by(id).dispatchEvent(new Event(event)); };
  const look = () => ({
    rows: all("#overview tbody tr").filter((one) => one.checkVisibility()).map((one) => one.dataset.code),
    heads: all(".head").filter((one) => one.checkVisibility()).map((one) => one.dataset.code),
    families: all("#overview th[data-family]").filter((one) => one.checkVisibility()).map((one) => one.textContent),
    sections: all(".family").filter((one) => one.checkVisibility()).map((one) => one.dataset.family),
    ids: all(".one").filter((one) => !one.closest("[hidden]")).map((one) => one.querySelector(".id").textContent),
    groups: all(".group").filter((one) => one.checkVisibility()).length, shown: by("shown").textContent });
  const found = {first: look()};
  set("words", "value", "REFERENCE", "input"); found.words = look(); set("words", "value", "", "input");
  set("family", "value", "recovery", "input"); found.family = look(); set("family", "value", "", "input");
  set("differs", "checked", true, "input"); found.differs = look();
  set("differs", "checked", false, "input"); found.last = look();
  set("order", "value", "wrong", "change"); found.wrong = look();
  document.querySelector('th[data-sort="wrong"] button').click(); found.down = look();
  document.querySelector('th[data-sort="grade"] button').click(); found.grade = look();
  set("words", "value", "nothing has these words", "input"); found.none = look();
  location.hash = "#signs-1-2";
  setTimeout(() => {
    found.opened = by("signs-1-2").checkVisibility(); found.after = look();
    const said = document.createElement("pre"); said.id = "seen"; said.textContent = JSON.stringify(found);
    document.body.append(said); }, 300);
});
</script>
"""


def test_it_sorts_and_filters(chromium, tmp_path):
    bad = {**EASY, "signs.sea[a]": "fail", "recovery.pair[a]": "fail"}
    good = {**EASY, "signs.sea[a]": "unsupported"}
    found = codes(tmp_path, record("bad", verdicts=bad), record("good", verdicts=good), record("the reference"))
    path = tmp_path / "page.html"
    path.write_text(page(found).replace("<head>", "<head>" + DO, 1), encoding="utf-8")
    dom, console = chromium(path, "--dump-dom", "--window-size=1400,950", "--virtual-time-budget=5000")
    assert console == []
    seen = json.loads(unescape(re.findall(r'<pre id="seen">(.*?)</pre>', dom, re.DOTALL)[-1]))
    first = seen["first"]
    assert (first["rows"], first["heads"], first["shown"]) == (
        ["1", "2", "3"],
        ["1", "2", "3"],
        "15 of 15 findings shown",
    )
    assert first["families"] == first["sections"] == ["signs", "recovery", "synthesis", "conformance"]
    assert first["groups"] == 12
    assert seen["last"] == first
    assert (seen["words"]["rows"], seen["words"]["shown"]) == (["3"], "5 of 15 findings shown")
    assert seen["family"]["families"] == seen["family"]["sections"] == ["recovery"]
    assert seen["family"]["ids"] == ["recovery.pair[a]"] * 3
    assert seen["differs"]["sections"] == ["signs", "recovery"]
    assert sorted(set(seen["differs"]["ids"])) == ["recovery.pair[a]", "signs.sea[a]"]
    assert seen["wrong"]["rows"] == seen["wrong"]["heads"] == ["2", "3", "1"]
    assert seen["down"]["rows"] == ["1", "2", "3"]
    assert seen["grade"]["rows"] == ["2", "3", "1"]
    assert (seen["none"]["rows"], seen["none"]["sections"]) == ([], [])
    assert seen["opened"] is True  # a link shows what it leads to, whatever was hidden
    assert seen["after"]["shown"] == first["shown"]


def test_it_prints(chromium, mixed, tmp_path):
    (tmp_path / "page.html").write_text(mixed, encoding="utf-8")
    chromium(tmp_path / "page.html", f"--print-to-pdf={tmp_path / 'page.pdf'}", "--no-pdf-header-footer")
    assert (tmp_path / "page.pdf").read_bytes().startswith(b"%PDF-")
