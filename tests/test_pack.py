"""The golden pack: whole, the same bytes every time, and sharp in every language in which it is read."""

from __future__ import annotations

import json
import subprocess
from contextlib import nullcontext
from importlib import import_module
from zipfile import ZipFile

import numpy as np
import pytest
from scipy import io
from test_commands import leakref as command
from test_golden import PERCENT, percent, rewritten
from tools import requires

from leakref import LeakrefError
from leakref.exam import pack
from leakref.exam.storing import sha256
from leakref.golden.sets import NEWEST
from leakref.golden.stages import STAGES

pytestmark = pytest.mark.stored
ENTRIES = pack.vectors(NEWEST)
OCTAVE = """
function drive()
  lines = strsplit(strtrim(fileread('scenarios.tsv')), sprintf('\\n'));
  for n = 1:numel(lines)
    cells = strsplit(lines{n}, sprintf('\\t'));
    code = @(stage, given) replay(cells{1}, given.id);
    if ~strcmp(cells{2}, 'all'), code = struct(strrep(cells{2}, '-', '_'), @(given) replay(cells{1}, given.id)); end
    failed = leakref_check(code);
    printf('RESULT %s %d\\n', cells{1}, failed);
  end
end
function found = replay(place, id)
  lines = strsplit(strtrim(fileread(fullfile(place, [id '.tsv']))), sprintf('\\n'));
  for n = 1:numel(lines)
    cells = strsplit(lines{n}, sprintf('\\t'));
    shape = str2double(strsplit(cells{2}, ','));
    values = str2double(strsplit(cells{3}, ' '));
    if numel(shape) > 1, values = permute(reshape(values, fliplr(shape)), numel(shape):-1:1); end
    found.(cells{1}) = values;
  end
end
"""
CPP = """
#include "leakref_check.hpp"
leakref::Given replay(const std::string& place, const std::string& id) {
  leakref::Given found;
  for (const auto& line : leakref::split(leakref::content(place + "/" + id + ".tsv"), '\\n')) {
    const auto cells = leakref::split(line, '\\t');
    if (cells.size() < 3) continue;
    for (const auto& one : leakref::split(cells[2], ' ')) found[cells[0]].push_back(std::stod(one));
  }
  return found;
}
int main() {
  for (const auto& line : leakref::split(leakref::content("scenarios.tsv"), '\\n')) {
    const auto cells = leakref::split(line, '\\t');
    if (cells.size() < 2) continue;
    leakref::Stages stages;
    for (const auto& name : leakref::split(cells[1] == "all" ? EVERY : cells[1], ' '))
      stages[name] = [&](const leakref::Given&, const leakref::Question& q) { return replay(cells[0], q.id); };
    const int status = leakref::check(stages);
    std::printf("RESULT %s %d\\n", cells[0].c_str(), status);
  }
}
"""
R = """
source("leakref_exam.R"); source("leakref_check.R")
replay <- function(place, id) {
  found <- list()
  for (line in readLines(file.path(place, paste0(id, ".tsv")))) {
    cells <- strsplit(line, "\\t")[[1]]
    shape <- as.numeric(strsplit(cells[2], ",")[[1]])
    values <- as.numeric(strsplit(cells[3], " ")[[1]])
    found[[cells[1]]] <- if (length(shape) > 1) aperm(array(values, rev(shape))) else values
  }
  found
}
for (line in readLines("scenarios.tsv")) {
  cells <- strsplit(line, "\\t")[[1]]
  stages <- list()
  for (name in if (cells[2] == "all") EVERY else cells[2]) stages[[name]] <- function(given) replay(cells[1], given$id)
  table <- leakref_check(stages)
  cat(sprintf("RESULT %s %d\\n", cells[1], sum(!table$pass)))
}
"""
LANGUAGES = ("octave", "cpp", "r")


@pytest.fixture(scope="module")
def archive(tmp_path_factory):
    path = tmp_path_factory.mktemp("pack") / "golden.zip"
    pack.pack(path, "raw", NEWEST)
    return path


@pytest.fixture
def place(archive, tmp_path):
    with ZipFile(archive) as held:
        held.extractall(tmp_path)
    return tmp_path


def computed(entry, stages=STAGES, route=0):
    """What a chain makes of an entry, as text, by one of the routes of the stage."""
    with np.errstate(all="ignore"):
        found = list(stages[entry.stage].routes.values())[route](entry.input)
    lines = []
    for name in entry.output:
        value = np.atleast_1d(np.array(found[name], dtype=np.float64))
        words = " ".join(map(repr, value.ravel().tolist())) if value.size else "nan"
        lines.append(f"{name}\t{','.join(map(str, value.shape))}\t{words}\n")
    return "".join(lines)


def scenario(place, name, entries, stages=STAGES, route=0):
    (place / name).mkdir()
    for entry in entries:
        (place / name / f"{entry.id}.tsv").write_text(computed(entry, stages, route))


def drive(place, language, scenarios):
    """What the runner of a language prints of some scenarios, and how many vectors it finds to fall short in each."""
    (place / "scenarios.tsv").write_text("".join(f"{name}\t{stage}\n" for name, stage in scenarios.items()))
    every = sorted({entry.stage for entry in ENTRIES})
    if language == "octave":
        (place / "drive.m").write_text(OCTAVE.strip() + "\n")
        words = [requires("octave-cli", "octave"), "--quiet", "--no-init-file", "--eval", "drive"]
    elif language == "cpp":
        names = " ".join(every)
        (place / "drive.cpp").write_text(CPP.replace("EVERY", f'std::string("{names}")'))
        build = [requires("g++"), "-std=c++17", "-O1", "-Wall", "-Wextra", "-Werror", "-o", "drive", "drive.cpp"]
        subprocess.run(build, cwd=place, check=True)
        words = [str(place / "drive")]
    else:
        names = ", ".join(f'"{name}"' for name in every)
        (place / "drive.R").write_text(R.replace("EVERY", f"c({names})"))
        words = [requires("Rscript"), "--vanilla", "drive.R"]
    done = subprocess.run(words, cwd=place, capture_output=True, text=True, timeout=900)
    assert done.returncode == 0, done.stdout[-1500:] + done.stderr[-1500:]
    rows = (line.split() for line in done.stdout.splitlines() if line.startswith("RESULT "))
    return done.stdout, {name: int(count) for _, name, count in rows}


def test_it_holds_every_vector_of_every_stage(place):
    lines = [line.split("\t") for line in (place / "vectors.tsv").read_text().splitlines()[2:]]
    assert [cells[0] for cells in lines] == [entry.id for entry in ENTRIES]
    assert {cells[1] for cells in lines} == set(STAGES)
    for cells, entry in zip(lines, ENTRIES, strict=True):
        for name, value in entry.output.items():
            folder = place / cells[4]
            right, allowed = (np.fromfile(folder / f"{prefix}{name}.f64", "<f8") for prefix in ("", "allowed_"))
            assert np.array_equal(right, value.ravel(), equal_nan=True)
            assert np.array_equal(allowed, np.broadcast_to(entry.tolerance(name), value.shape).ravel(), equal_nan=True)
        for name, value in pack.flattened(entry.input):
            if isinstance(value, np.ndarray):
                assert np.array_equal(
                    np.fromfile(place / cells[2] / f"{name}.f64", "<f8"), value.ravel(), equal_nan=True
                )
            else:
                assert f"{name}={value if isinstance(value, str) else json.dumps(value)}" in cells


def test_it_has_its_own_checksums_and_the_same_bytes_every_time(archive, place, tmp_path):
    sums = dict(reversed(line.split("  ")) for line in (place / "SHA256SUMS").read_text().splitlines())
    files = {path.relative_to(place).as_posix() for path in place.rglob("*") if path.is_file()}
    assert set(sums) == files - {"SHA256SUMS"}
    assert all(sha256((place / path).read_bytes()) == digest for path, digest in sums.items())
    again = tmp_path / "again.zip"
    assert pack.pack(again, "raw", NEWEST)["sha256"] == sha256(archive.read_bytes())


@pytest.mark.parametrize("form", ["mat", "npz", "netcdf"])
def test_every_format_holds_the_same(form, tmp_path):
    pack.pack(tmp_path / "golden.zip", form, 1)
    with ZipFile(tmp_path / "golden.zip") as held:
        held.extractall(tmp_path)
    lines = [line.split("\t") for line in (tmp_path / "vectors.tsv").read_text().splitlines()[2:]]
    entry = next(entry for entry in ENTRIES if entry.id == "transform-hann")
    cells = next(cells for cells in lines if cells[0] == entry.id)
    for path, values in ((cells[2], {"surface": np.array(entry.input["surface"])}), (cells[4], entry.output)):
        if form == "netcdf":
            with io.netcdf_file(tmp_path / path, mmap=False) as stored:
                found = {name: np.array(stored.variables[name][...]) for name in values}
        else:
            found = (io.loadmat if form == "mat" else np.load)(tmp_path / path)
        assert all(np.array_equal(found[name], value) for name, value in values.items())


@pytest.mark.parametrize("language", LANGUAGES)
def test_a_runner_passes_what_is_right_and_finds_what_is_not(language, place):
    """Every vector by the chain; then one number off by one and a half times its tolerance, a NaN for a number, a
    number for a NaN, an output that lacks, and another shape.
    """
    scenario(place, "same", ENTRIES)
    chosen = {entry.id: entry for entry in ENTRIES if entry.stage in ("window", "ls")}
    scenario(place, "off", chosen.values())
    path = place / "off" / "window-hann-7.tsv"
    name, shape, values = path.read_text().split("\t")
    numbers = list(map(float, values.split()))
    numbers[2] += 1.5 * float(chosen["window-hann-7"].tolerance("w"))
    path.write_text(f"{name}\t{shape}\t{' '.join(map(repr, numbers))}\n")
    path = place / "off" / "window-box-7.tsv"
    path.write_text(path.read_text().replace("1.0", "nan", 1))
    (place / "off" / "window-box-12.tsv").write_text("v\t12\t" + " ".join(["1.0"] * 12) + "\n")
    (place / "off" / "window-hann-12.tsv").write_text("w\t2\t0.0 1.0\n")
    silent = [
        entry.id for entry in chosen.values() if entry.stage == "ls" and np.isnan(entry.output["velocities"]).any()
    ]
    for identifier in silent:
        path = place / "off" / f"{identifier}.tsv"
        path.write_text(path.read_text().replace("nan", "0.5"))
    printed, counts = drive(place, language, {"same": "all", "off": "window"})
    assert counts["same"] == 0, printed
    assert f"{len(ENTRIES)} of {len(ENTRIES)} vectors pass" in printed
    wrong = [line.split()[0] for line in printed.splitlines() if "FAIL" in line]
    assert wrong == ["window-box-7", "window-box-12", "window-hann-7", "window-hann-12"]
    assert counts["off"] == (1 if language == "cpp" else 4)
    if silent:
        printed, _ = drive(place, language, {"off": "ls"})
        assert {line.split()[0] for line in printed.splitlines() if "FAIL" in line} == set(silent)


def changed(place, factor, constants):
    """For each constant what a chain in which it is off makes of the stage in which it acts, by every route."""
    scenarios = {}
    for n, (module, where, number, stage) in enumerate(constants):
        with np.errstate(all="ignore"), rewritten(module, where, percent(where, number, factor)):
            stages = import_module("leakref.golden.stages").STAGES
            for route in range(len(stages[stage].routes)):
                scenario(place, f"{n}-{route}", [e for e in ENTRIES if e.stage == stage], stages, route)
                scenarios[f"{n}-{route}"] = stage
    return scenarios


def unseen(counts, constants):
    """The constants that no route shows to be off."""
    seen = {int(name.partition("-")[0]) for name, count in counts.items() if count}
    return [one for n, one in enumerate(constants) if n not in seen]


FEW = [one for one in PERCENT if one[3] in ("window", "ls", "characteristic", "kernel")][::4]
whole = pytest.mark.filterwarnings("ignore::RuntimeWarning")  # what a wrong constant leads to


@whole
def test_a_few_constants_one_percent_off_are_seen(place):
    scenarios = changed(place, 1.01, FEW)
    assert len(FEW) >= 3
    _, counts = drive(place, "cpp", scenarios)
    assert unseen(counts, FEW) == []


@whole
@pytest.mark.slow
@pytest.mark.parametrize("factor", [0.99, 1.01])
def test_every_constant_one_percent_off_is_seen_where_it_acts(factor, place):
    scenarios = changed(place, factor, PERCENT)
    for language in LANGUAGES:
        _, counts = drive(place, language, scenarios)
        assert unseen(counts, PERCENT) == [], language


def test_the_command_says_what_it_wrote(tmp_path):
    done = command("golden", "pack", "--format", "mat", "--out", tmp_path / "g.zip", "--json")
    said = json.loads(done.stdout)
    assert (said["schema"], said["action"], said["entries"]) == ("leakref/golden/1", "pack", len(ENTRIES))
    assert said["sha256"] == sha256((tmp_path / "g.zip").read_bytes())
    with nullcontext(pytest.raises(LeakrefError, match="no format is called")) as refused, refused:
        pack.pack(tmp_path / "h.zip", "zip", 1)
    with pytest.raises(LeakrefError, match="is a folder"):
        pack.pack(tmp_path, "raw", 1)
