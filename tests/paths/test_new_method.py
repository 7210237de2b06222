"""A method is one class and one line: every list, text, table and option then has it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
import typer
from typer.testing import CliRunner

import elastomorph as em
import elastomorph.paths.options as options
from elastomorph.character import read_settings, rig_from_settings, settings_tables
from elastomorph.cli import completion
from elastomorph.cli.interpolate import interpolate
from elastomorph.cli.verb import VerbWithOptions
from elastomorph.curves import CurveNetwork
from elastomorph.evaluation import every_method
from elastomorph.model.bend_curve import BendCurve
from elastomorph.paths.straight import straight_path


@dataclass(frozen=True)
class Hop(em.Method):
    """The straight line with a bump of t(1 - t) to a power, so that it hurries and waits.

    Attributes:
        power: Of t(1 - t).
        height: How far the bump is ahead halfway, as a fraction of the way.
    """

    name = "hop"
    path = "straight line that hurries first"

    power: int = options.whole_number(
        1,
        "power of the bump t(1 - t)",
        "2",
        least=1,
        label=lambda power: f"^{power}",
        word=options.Word(
            lambda text: int(text) if text.isdigit() else None, "power", "power", ("2",)
        ),
    )
    height: float = options.number(0.1, "how far it is ahead halfway", "0.2", least=0)

    def prepare(self, neutral: em.Mesh, curves: CurveNetwork | None = None) -> options.Any:
        """A function from target to path."""
        bump = np.polynomial.Polynomial([0.0, 4.0, -4.0]) ** self.power
        return straight_path(neutral, BendCurve.polynomial(self.height * bump.coef), self.label)


@pytest.fixture(autouse=True)
def _registered(monkeypatch: pytest.MonkeyPatch) -> None:
    """The line in `elastomorph.paths`."""
    monkeypatch.setattr(em.Method, "known", (*em.Method.known, Hop))


def faces() -> tuple[em.Mesh, em.Mesh]:
    grid = np.stack(np.meshgrid([0.0, 1.0, 2.0], [0.0, 1.0, 2.0]), axis=-1).reshape(-1, 2)
    neutral = em.Mesh(
        np.column_stack([grid, np.zeros(9)]), [[0, 1, 4, 3], [1, 2, 5, 4], [3, 4, 7, 6]]
    )
    return neutral, neutral.with_vertices(neutral.vertices + [0.0, 0.0, 1.0])


def at_half(morph: em.Morph) -> float:
    return float(morph.at(0.5)[0, 2])


def test_paths_and_rigs_are_made_by_it() -> None:
    neutral, target = faces()
    assert at_half(em.interpolate(neutral, target, "hop")) == pytest.approx(0.6)
    assert at_half(em.interpolate(neutral, target, "hop:2", height=0.3)) == pytest.approx(0.8)
    assert at_half(em.prepare(neutral, Hop(height=0.2))(target)) == pytest.approx(0.7)
    rig = em.Rig(neutral, {"smile": target}, method="hop:3")
    assert rig.morphs["smile"].method == "hop ^3"
    assert em.Method("hop", power=3) == em.Method.parse("hop:3") == Hop(power=3)


@pytest.mark.parametrize(
    ("method", "given", "message"),
    [
        ("hop", {"order": 2}, "method 'hop': hop has no order; it has power, height"),
        ("linear", {"height": 0.2}, "method 'linear': linear has no height; it has no settings"),
        ("hop:2", {"power": 2}, "method 'hop:2': the power is given twice; leave one of them out"),
        ("hop:high", {}, "method 'hop:high': 'high' is no power"),
        ("hop", {"height": -1}, "height must be a number ≥ 0, found -1"),
        ("hop:0", {}, "power must be a whole number ≥ 1, found 0"),
        ("hip", {}, "method must be one of linear, .*, auto, hop, found 'hip'"),
    ],
)
def test_what_it_has_not_is_refused(method: str, given: dict[str, object], message: str) -> None:
    with pytest.raises(em.ParameterError, match=message):
        em.interpolate(*faces(), method, **given)  # type: ignore[arg-type]


def test_it_is_judged() -> None:
    neutral, target = faces()
    moment = em.interpolate(neutral, target, "hop").at(0.5)
    motion = em.MeshSequence(neutral, np.stack([neutral.vertices, moment, target.vertices]))
    curves = em.extract_curves(neutral)
    judged = em.evaluate(motion, ["linear", "hop", "hop:2"], curves)
    assert [result.label for result in judged.results] == ["linear", "hop", "hop ^2"]
    assert judged.results[1].lme < 1e-12 < judged.results[0].lme
    assert "hop" in every_method(motion, curves)


def test_settings_have_its_options(tmp_path: Path) -> None:
    neutral, target = faces()
    em.write(tmp_path / "neutral.obj", neutral)
    em.write(tmp_path / "smile.obj", target)
    file = tmp_path / "elastomorph.toml"
    file.write_text('[method]\ndefault = "hop:2"\nheight = 0.4\n')
    settings = read_settings(file)
    rig = rig_from_settings(settings, cache=None)
    assert at_half(rig.morphs["smile"]) == pytest.approx(0.9)
    kept = settings_tables(settings)["method"]
    assert kept == {"default": "hop", "power": 2, "height": 0.4}
    file.write_text('[method]\ndefault = "hop"\nheight = "high"\n')
    with pytest.raises(em.FormatError, match=r"line 3: 'method\.height' must be a finite number"):
        read_settings(file)
    file.write_text('[method]\ndefault = "linear"\nheight = 0.3\n')
    with pytest.warns(em.ElastomorphWarning, match="'height' has no effect: it is for hop, and"):
        read_settings(file)


def call(*words: object) -> object:
    """What the verb answers, with a command line that is made anew."""
    app = typer.Typer()
    app.callback()(lambda: None)
    app.command(cls=VerbWithOptions)(interpolate)
    return CliRunner().invoke(app, ["interpolate", *map(str, words)], env={"COLUMNS": "200"})


def test_the_command_line_has_its_options(tmp_path: Path) -> None:
    for name, mesh in zip(("neutral", "smile"), faces(), strict=True):
        em.write(tmp_path / f"{name}.obj", mesh)
    meshes = (tmp_path / "neutral.obj", tmp_path / "smile.obj", "-o", tmp_path / "half.obj")
    done = call(*meshes, "--method", "hop:3", "--height", 0.4)
    assert done.exit_code == 0, done  # type: ignore[attr-defined]
    assert em.read(tmp_path / "half.obj").vertices[0, 2] == pytest.approx(0.9)
    help_text = call("--help").output  # type: ignore[attr-defined]
    assert "--height" in help_text
    assert "How far it is ahead halfway; 0.1 by default. For hop." in help_text
    assert "rotation, auto[:distance] or hop[:power]" in " ".join(help_text.split())
    refused = call(*meshes, "--method", "linear", "--height", 0.4)
    message = "--height is for hop; linear has none: add --method hop"
    assert str(refused.exception) == message  # type: ignore[attr-defined]
    assert call(*meshes, "--method", "hop", "--hight", 0.4).exit_code == 2  # type: ignore[attr-defined]
    assert completion.methods("ho") == ["hop", "hop:2"]


def test_the_list_of_options_has_its_own() -> None:
    row = ("height", "number", "how far it is ahead halfway", "0.1", ("hop",))
    assert options.option_rows(em.Method.known)[-1] == row
