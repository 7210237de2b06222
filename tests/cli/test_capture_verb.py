"""The verb that makes poses of photographs: what it writes, prints and refuses."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import pytest
from calls import printed_by, status_of

import elastomorph as em
from elastomorph.capturing.landmarks import write_landmarks
from needs import extra

extra("pycolmap", "capture")

sys.path.append(str(Path(__file__).parents[1] / "capture"))
from small_captures import COUNT, Counted, landmarks, template, write_photographs  # noqa: E402


@pytest.fixture
def counted(monkeypatch: pytest.MonkeyPatch) -> Counted:
    """Stages that take no time stand for the real ones."""
    from elastomorph.capturing.work import makers

    counted = Counted([])
    monkeypatch.setattr(makers, "Makers", lambda: counted)
    return counted


@pytest.fixture
def case(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    photos = write_photographs(tmp_path / "photos")
    write_landmarks(photos / "landmarks.json", landmarks())
    em.write(tmp_path / "face.obj", template())
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_it_writes_poses_and_says_what_was_measured(case: Path, counted: Counted) -> None:
    text = printed_by("capture", "photos", "-o", "poses", "--template", "face.obj")
    assert [line.split()[:4] for line in text.splitlines() if " of " in line and "%" not in line][
        :1
    ] == [["neutral", str(COUNT), "of", str(COUNT)]]
    assert text.endswith("written to poses/\n")
    assert {file.name for file in (case / "poses").iterdir()} == {
        *("neutral.obj", "a.obj", "b.obj", "c.obj"),
        *("confidence.npz", "capture.json", "cameras", "report.html", ".capture"),
    }


def test_for_machines_it_prints_the_figures_that_it_writes(case: Path, counted: Counted) -> None:
    words = ("capture", "photos", "-o", "poses", "--template", "face.obj", "--json")
    printed = json.loads(printed_by(*words))
    written = json.loads((case / "poses" / "capture.json").read_text())
    assert printed["poses"] == written["poses"]
    assert printed["written"][0] == str(Path("poses") / "neutral.obj")
    assert set(written["cameras"]["a"]) == {f"{k}.jpg" for k in range(COUNT)}
    assert written["cameras"]["a"]["0.jpg"]["file"] == "../photos/a/0.jpg"


def test_the_report_names_photographs_and_no_folders(case: Path, counted: Counted) -> None:
    words = ("capture", "photos", "-o", "poses", "--template", "face.obj")
    assert json.loads(printed_by(*words, "--json"))["written"][-1] == str(
        Path("poses") / "report.html"
    )
    page = (case / "poses" / "report.html").read_text(encoding="utf-8")
    assert "<h1>photos</h1>" in page
    assert "elastomorph capture photos --output poses --template face.obj" in page
    assert str(case) not in page
    (case / "poses" / "report.html").unlink()
    written = json.loads(printed_by(*words, "--no-report", "--json"))["written"]
    assert not [name for name in written if name.endswith("html")]
    assert not (case / "poses" / "report.html").exists()


def test_cameras_need_no_template(case: Path, counted: Counted) -> None:
    printed_by("capture", "photos", "-o", "cameras", "--to", "cameras", "--no-report")
    assert [file.name for file in (case / "cameras").iterdir() if file.is_file()] == [
        "capture.json"
    ]
    counted.calls.clear()
    printed_by(
        *[
            "capture",
            "photos",
            "-o",
            "poses",
            "--template",
            "face.obj",
            "--working",
            "cameras/.capture",
        ]
    )
    assert not [call for call in counted.calls if "cameras" in call]
    assert not (case / "poses" / ".capture").exists()


def test_the_template_is_not_written_over(
    case: Path, counted: Counted, capsys: pytest.CaptureFixture[str]
) -> None:
    (case / "poses").mkdir()
    (case / "face.obj").rename(case / "poses" / "neutral.obj")
    before = (case / "poses" / "neutral.obj").read_bytes()
    assert status_of("capture", "photos", "-o", "poses", "--template", "poses/neutral.obj") == 1
    assert "it is the template, over which the pose would be written" in capsys.readouterr().err
    assert (case / "poses" / "neutral.obj").read_bytes() == before
    assert not counted.calls


def test_an_interrupt_says_that_what_is_finished_is_kept(
    case: Path, counted: Counted, capsys: pytest.CaptureFixture[str]
) -> None:
    def interrupt(stage: str) -> None:
        if stage == "neutral":
            raise KeyboardInterrupt

    counted.before = interrupt
    assert status_of("capture", "photos", "-o", "poses", "--template", "face.obj") == 130
    assert "the same command goes on behind it" in capsys.readouterr().err
    counted.before = lambda stage: None
    counted.calls.clear()
    printed_by("capture", "photos", "-o", "poses", "--template", "face.obj")
    assert counted.calls[0] == "neutral"


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("capture nowhere -o poses", "nowhere: there is no such folder of photographs"),
        ("capture photos -o poses", "a template is needed"),
        ("capture photos -o poses --template face.obj --to end", "to must be cameras, neutral or"),
        ("capture photos -o poses --to cameras --rig still", "rig must be walking or fixed"),
        ("capture photos -o poses --to cameras --masks no", "there is no such folder of masks"),
        ("capture photos -o face.obj --to cameras", "this is a file; name a folder"),
    ],
)
def test_what_cannot_be_is_one_sentence(
    case: Path, counted: Counted, capsys: pytest.CaptureFixture[str], words: str, message: str
) -> None:
    assert status_of(*words.split()) == 1
    said = capsys.readouterr().err
    assert said.startswith("error: ")
    assert message in said
    assert len(said.splitlines()) == 1
    assert not counted.calls
