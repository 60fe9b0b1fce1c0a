"""An exported cube in Octave, and Octave's own files here."""

from __future__ import annotations

import subprocess
from importlib import resources

import numpy as np
import pytest
from tools import requires

from leakref.cases import Configuration
from leakref.cubes import files
from leakref.dispersion import Scales
from leakref.golden.sets import Golden, locate


@pytest.fixture(scope="module")
def octave():
    program = requires("octave-cli", "octave")

    def run(code, cwd):
        done = subprocess.run(
            [program, "--quiet", "--no-init-file", "--no-history", "--eval", code],
            capture_output=True,
            text=True,
            cwd=cwd,
            timeout=120,
        )
        assert done.returncode == 0, done.stderr
        return done.stdout

    return run


def test_octave_reads_what_was_exported(octave, tmp_path):
    configuration = Configuration("small", length=1.5, duration=1.0, speed=0.1, current_direction=40.0)
    cube = files.of_configuration(configuration, 5, Scales(0.4, 9.81))
    files.write(tmp_path / "cube.mat", cube, "mat")
    said = octave(
        """load cube.mat
        printf("%d ", size(eta), size(x), size(kx)); printf("\\n");
        printf("%.17g ", eta(3, 5, 7), eta(end, 1, 2), x(2), y(end), t(2), gravity, current, peak_wavenumber);
        printf("\\n%s\\n", units);
        [X, Y] = ndgrid(x, y); worst = 0;
        for m = [1 8 numel(t)]  % the surface once more, from the waves in the file
          again = zeros(size(X));
          for n = 1:numel(kx)
            again += amplitude(n) * cos(kx(n) * X + ky(n) * Y - omega(n) * t(m) + phase(n));
          end
          worst = max(worst, max(max(abs(again - eta(:, :, m)))));
        end
        printf("%.17g\\n", worst);""",
        tmp_path,
    ).splitlines()
    nx, ny, nt = cube.grid.shape
    assert said[0].split() == [str(n) for n in (nx, ny, nt, 1, nx, 1, cube.components.kx.size)]
    values = [
        cube.surface[2, 4, 6],
        cube.surface[-1, 0, 1],
        cube.grid.spacing[0],
        cube.grid.samples(1)[-1],
        cube.grid.spacing[2],
        9.81,
        *cube.current,
        0.4,
    ]
    assert [float(word) for word in said[1].split()] == values
    assert said[2] == "si"
    # each wave is off by the rounding of its phase, at most 100 rad: 100 eps times its amplitude
    assert 0 < float(said[3]) < 100 * np.finfo(float).eps * cube.components.amplitude.sum()


@pytest.mark.parametrize("option", ["-v6", "-v7"])
@pytest.mark.parametrize("kind", ["double", "single", "uint8", "int16"])
def test_what_octave_saves_is_read(octave, tmp_path, option, kind):
    octave(
        f"""eta = {kind}(reshape(0:209, 5, 6, 7)); x = (0:4) * 0.3; y = (0:5)' * 0.7; t = (0:6) * 0.11;
        gravity = 9.81; units = "si"; other = {{1, "a"}};
        save("{option}", "cube.mat", "eta", "x", "y", "t", "gravity", "units", "other");""",
        tmp_path,
    )
    cube = files.read(tmp_path / "cube.mat")
    assert np.array_equal(cube.surface, np.arange(210.0).reshape((5, 6, 7), order="F"))
    assert cube.grid.spacing == (0.3, 0.7, 0.11)
    assert (cube.gravity, cube.units) == (9.81, "si")


def snippet(language: str) -> str:
    """The first block of code in that language in golden/README.md."""
    readme = resources.files("leakref._golden").joinpath("README.md").read_text(encoding="utf-8")
    return readme.partition(f"```{language}\n")[2].partition("```")[0]


@pytest.fixture
def beside_golden(tmp_path):
    """A folder with `golden/` in it, as the README's snippets want it."""
    (tmp_path / "golden").mkdir()
    for number in (1, 2):
        (tmp_path / "golden" / f"v{number}").symlink_to(str(locate(number)))
    return tmp_path


LOOKED_AT = (3, 1, 7)
CUBE = Golden().file("vectors/extract.json")[2].input["surface"]  # the first of v2: v1 has two


def test_golden_values_are_read_as_the_readme_says(octave, beside_golden):
    x, y, t = (n + 1 for n in LOOKED_AT)
    code = f'printf("%d ", size(eta)); printf("%.17g ", eta({x}, {y}, {t}), eta(end), w, allowed);'
    found = list(map(float, octave(snippet("matlab") + code, beside_golden).split()))
    assert tuple(found[:3]) == CUBE.shape
    assert found[3:5] == [CUBE[LOOKED_AT], CUBE[-1, -1, -1]]
    *w, allowed = found[5:]
    entry = Golden().entry("window-hann-7")
    # jsondecode of Octave is not always right in the last bit
    assert np.allclose(w, entry.output["w"], rtol=2**-52, atol=0)
    assert np.isclose(allowed, float(entry.tolerance("w")), rtol=2**-52, atol=0)


def test_golden_values_are_read_by_python_as_the_readme_says(beside_golden, monkeypatch):
    monkeypatch.chdir(beside_golden)
    names: dict = {}
    exec(snippet("python").replace("json.load(open(", "json.loads(open_text("), {"open_text": read_text}, names)
    np.testing.assert_array_equal(names["eta"], CUBE)
    np.testing.assert_array_equal(names["w"], Golden().entry("window-hann-7").output["w"])


def read_text(path):
    with open(path, encoding="utf-8") as stream:
        return stream.read()


def test_a_golden_cube_is_read_by_cpp_as_the_readme_says(beside_golden):
    """All but the JSON, whose library need not be there: shape and name are put in."""
    compiler = requires("g++")
    lines = snippet("cpp").partition("std::vector<double> eta")[2]
    code = "std::vector<double> eta" + lines.replace(
        'cube["f64"].get<std::string>()', 'std::string("extract-wide.f64")'
    )
    shape = ", ".join(f"{name} = {n}" for name, n in zip(("nx", "ny", "nt"), CUBE.shape, strict=True))
    x, y, t = LOOKED_AT
    (beside_golden / "read.cpp").write_text(
        "#include <cstdio>\n#include <fstream>\n#include <string>\n#include <vector>\nint main() {\n"
        f"std::size_t {shape};\n{code}\n"
        f'std::printf("%.17g %.17g", eta[({x} * ny + {y}) * nt + {t}], eta.back());\n}}\n'
    )
    subprocess.run([compiler, "-std=c++17", "-o", "read", "read.cpp"], cwd=beside_golden, check=True)
    done = subprocess.run(["./read"], cwd=beside_golden, check=True, capture_output=True, text=True)
    assert list(map(float, done.stdout.split())) == [CUBE[LOOKED_AT], CUBE[-1, -1, -1]]
