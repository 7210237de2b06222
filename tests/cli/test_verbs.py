"""The command line from end to end, on small meshes."""

from __future__ import annotations

import csv
import json
import re
from pathlib import Path

import numpy as np
import pytest
from calls import status_of as run

import elastomorph as em
from small_meshes import grid

SIZE = 7


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with neutral.obj, target.obj and a motion scan.1.obj … scan.5.obj."""
    monkeypatch.chdir(tmp_path)
    neutral = grid(SIZE, SIZE)
    raised = neutral.vertices + [0, 0, 3.0]
    em.write("neutral.obj", neutral)
    em.write("target.obj", neutral.with_vertices(raised))
    path = em.interpolate(neutral, neutral.with_vertices(raised), "ease:2")
    em.write_sequence("scan.#.obj", em.MeshSequence(neutral, path.at(np.linspace(0, 1, 5))))
    return tmp_path


@pytest.mark.usefixtures("folder")
class TestVerbs:
    """Each verb does its job, or one sentence says why not."""

    def test_inspect(self, capsys: pytest.CaptureFixture[str]) -> None:
        assert run("inspect", "neutral.obj", "target.obj", "--json") == 0
        facts = json.loads(capsys.readouterr().out)
        assert facts["vertices"] == SIZE**2
        assert facts["polygons"] == {"4": 36}
        assert facts["border_edges"] == 24
        assert facts["targets"]["target.obj"]["moved"] == SIZE**2
        assert run("inspect", "neutral.obj") == 0
        assert "36 quads" in capsys.readouterr().out

    def test_curves(self, capsys: pytest.CaptureFixture[str]) -> None:
        assert run("curves", "neutral.obj", "-o", "curves.json", "--json") == 0
        facts = json.loads(capsys.readouterr().out)
        written = json.loads(Path("curves.json").read_text())
        assert facts["curves"] == len(written["curves"])
        covered = [v for curve in written["curves"] for v in curve["vertices"]]
        assert sorted(covered) == list(range(SIZE**2))

    def test_artists_curves_are_kept(self) -> None:
        Path("own.json").write_text(json.dumps({"curves": [{"vertices": [0, 8, 16, 24]}]}))
        assert run("curves", "neutral.obj", "--curves", "own.json", "-o", "all.json") == 0
        written = json.loads(Path("all.json").read_text())["curves"]
        assert [0, 8, 16, 24] in [curve["vertices"] for curve in written]
        assert sum(len(curve["vertices"]) for curve in written) == SIZE**2

    def test_interpolate_one_time(self) -> None:
        assert run("interpolate", "neutral.obj", "target.obj", "-t", 0.25, "-o", "out.obj") == 0
        np.testing.assert_allclose(em.read("out.obj").vertices[:, 2], 3 / 4, atol=1e-12)
        words = ["-t", 0.25, "-o", "out.obj", "--method", "beam:2"]
        assert run("interpolate", "neutral.obj", "target.obj", *words) == 0
        np.testing.assert_allclose(em.read("out.obj").vertices[:, 2], 3 / 16, atol=1e-12)

    def test_interpolate_frames(self) -> None:
        pattern = "half.####.ply"
        assert (
            run("interpolate", "neutral.obj", "target.obj", "--frames", 3, "-o", pattern,
                "--method", "linear") == 0
        )  # fmt: skip
        heights = [mesh.vertices[0, 2] for mesh in em.read_sequence(pattern)]
        np.testing.assert_allclose(heights, [0, 1.5, 3])

    def test_interpolate_with_a_timing(self) -> None:
        """Smoothstep at a quarter is 5/32; the path itself is the straight one."""
        assert (
            run("interpolate", "neutral.obj", "target.obj", "-t", 0.25, "-o", "out.obj",
                "--method", "linear", "--timing", "smoothstep") == 0
        )  # fmt: skip
        np.testing.assert_allclose(em.read("out.obj").vertices[:, 2], 3 * 5 / 32, atol=1e-12)

    def test_interpolate_a_region(self) -> None:
        assert (
            run("interpolate", "neutral.obj", "target.obj", "-o", "out.obj", "--region", "0-20",
                "--rest", "neutral") == 0
        )  # fmt: skip
        height = em.read("out.obj").vertices[:, 2]
        assert height[0] == pytest.approx(3 / 2)
        assert not height[21:].any()

    def test_evaluate(self, capsys: pytest.CaptureFixture[str]) -> None:
        assert (
            run("evaluate", "scan.#.obj", "--method", "linear", "--method", "ease:2", "-o", "out",
                "--no-pictures") == 0
        )  # fmt: skip
        assert "ease R=2" in capsys.readouterr().out
        rows = list(csv.DictReader(Path("out/table.csv").read_text().splitlines()))
        assert [row["label"] for row in rows] == ["linear", "ease R=2"]
        assert float(rows[0]["lme"]) == pytest.approx(3 / 4 / grid(SIZE, SIZE).diameter)
        assert float(rows[1]["lme"]) < 1e-12
        assert float(rows[0]["path_lme"]) < 1e-6
        assert json.loads(Path("out/evaluation.json").read_text())["methods"]

    def test_evaluate_laws_between_recorded_frames(
        self, capsys: pytest.CaptureFixture[str]
    ) -> None:
        texts = ("linear", "through:1:smooth", "through:1:piecewise")
        words = [word for text in texts for word in ("--method", text)]
        assert run("evaluate", "scan.#.obj", *words, "--json") == 0
        rows = json.loads(capsys.readouterr().out)["methods"]
        assert [row["label"] for row in rows] == [
            "linear",
            *(t.replace(":", " ") for t in texts[1:]),
        ]
        assert max(row["lme"] for row in rows[1:]) < rows[0]["lme"]

    def test_evaluate_every_method(self, capsys: pytest.CaptureFixture[str]) -> None:
        """All methods in one table, ranked, and whether the sheet stays rigid: it slides whole."""
        assert run("evaluate", "scan.#.obj", "--rigid", "0-48") == 0
        said = capsys.readouterr().out
        for label in ("plate R=2", "arc", "rotation", "auto", "through 1", "through 2"):
            assert label in said
        assert "At the captured times (LME): 1. " in said
        rigid = said[said.index("rigid body") :]
        assert "linear" in rigid
        assert rigid.count("0.000   0.000") == 13

    def test_all_adds_to_the_methods_named(self, capsys: pytest.CaptureFixture[str]) -> None:
        """A method named is compared alone; with --all it stands beside every other."""
        named = ("evaluate", "scan.#.obj", "--method", "ease:4", "--json")
        labels = []
        for more in ((), ("--all",)):
            assert run(*named, *more) == 0
            methods = json.loads(capsys.readouterr().out)["methods"]
            labels.append([method["label"] for method in methods])
        assert labels[0] == ["ease R=4"]
        assert {"linear", "auto", "through 2", "ease R=4"} <= set(labels[1])

    def test_evaluate_prints_json(self, capsys: pytest.CaptureFixture[str]) -> None:
        assert run("evaluate", "scan.#.obj", "--method", "linear", "--json") == 0
        assert json.loads(capsys.readouterr().out)["methods"][0]["label"] == "linear"

    @pytest.mark.parametrize(
        ("arguments", "message"),
        [
            (["inspect", "missing.obj"], "missing.obj"),
            (["curves", "bad.obj"], "bad.obj, line 2"),
            (["interpolate", "neutral.obj", "bad.obj", "-o", "x.obj"], "bad.obj, line 2"),
            (["interpolate", "neutral.obj", "other.obj", "-o", "x.obj"], "same order"),
            (["interpolate", "neutral.obj", "target.obj", "-o", "x.xyz"], "x.xyz"),
            (["interpolate", "neutral.obj", "target.obj", "-o", "x.obj", "--mass", "0"], "mass"),
            (
                ["interpolate", "neutral.obj", "target.obj", "-o", "x.obj", "--method", "beam:0"],
                "order R",
            ),
            (["interpolate", "neutral.obj", "target.obj", "-o", "x.obj", "-t", "nan"], "finite"),
            (
                ["interpolate", "neutral.obj", "target.obj", "-o", "x.obj", "--region", "5-3"],
                "5-3",
            ),
            (
                ["interpolate", "neutral.obj", "target.obj", "-o", "x.obj", "--damping", "50",
                 "--rigidity", "1.0265982254684336", "--method", "beam:2"],
                "resonant",
            ),
            (
                ["interpolate", "neutral.obj", "target.obj", "-o", "x.obj", "--damping", "50"],
                "--damping is for beam, plate; auto has none: add --method beam",
            ),
            (
                ["interpolate", "neutral.obj", "target.obj", "-o", "x.obj", "--method", "arc",
                 "--basis", "fourier"],
                "--basis is for beam; arc has none: add --method beam",
            ),
            (
                ["interpolate", "neutral.obj", "target.obj", "-o", "x.obj", "--timing", "soon"],
                "soon",
            ),
            (["evaluate", "scan.#.ply"], "scan.#.ply"),
            (["curves", "neutral.obj", "--curves", "twice.json"], "twice.json"),
            (["demo", "--data", "nowhere"], "nowhere"),
        ],
    )  # fmt: skip
    def test_mistakes(
        self, arguments: list[str], message: str, capsys: pytest.CaptureFixture[str]
    ) -> None:
        """Exit status 1, one sentence on standard error, nothing written."""
        Path("bad.obj").write_text("v 0 0 0\nv 0 x 0\n")
        em.write("other.obj", em.Mesh(grid(SIZE, SIZE).vertices, list(grid(SIZE, SIZE).faces)[1:]))
        Path("twice.json").write_text("[[1, 2], [2, 3]]")
        before = sorted(Path().iterdir())
        assert run(*arguments) == 1
        said = capsys.readouterr()
        assert said.err.startswith("error: ")
        assert message in said.err
        assert "Traceback" not in said.err
        assert sorted(Path().iterdir()) == before


def test_version_and_help(capsys: pytest.CaptureFixture[str]) -> None:
    assert run("--version") == 0
    assert capsys.readouterr().out.strip() == "0.2.0"
    assert run("--help") == 0
    for verb in ("demo", "inspect", "curves", "interpolate", "evaluate"):
        assert verb in capsys.readouterr().out or run(verb, "--help") == 0


@pytest.mark.slow
def test_demo_runs_the_whole_paper(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Every file it names is there, and the figures are those of the evaluation."""
    monkeypatch.setattr("elastomorph.draw.stage.LARGE", 0)  # one sample a pixel: nobody looks
    assert run("demo", "-o", tmp_path / "out", "--json") == 0
    facts = json.loads(capsys.readouterr().out)
    assert facts["vertices"] > 4000
    assert set(facts["seams"]) == {"unforced", "rest", "linear", "compatible", "limit"}
    assert facts["seams"]["limit"] < facts["seams"]["unforced"] / 50
    for name in facts["files"]:
        assert Path(name).stat().st_size > 0, name
    wanted = {"curves.png", "in-betweens.png", "errors-by-curve.png", "expressions.png"}
    wanted.add("report.html")
    assert wanted <= {Path(name).name for name in facts["files"]}
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    answer = page.partition('id="report"')[2].partition('id="appendix"')[0]
    unread = r"<svg.*?</svg>|(?<=</summary>).*?(?=</details>)|<[^>]*>"
    answer = re.sub(unread, " ", answer, flags=re.DOTALL)
    assert 300 < len(answer.split()) <= 1000
    rows = list(csv.DictReader((tmp_path / "out" / "table.csv").read_text().splitlines()))
    assert float(rows[0]["lme"]) == pytest.approx(facts["methods"]["linear"]["LME"])
