"""The page on settings names every key, and its examples are settings."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import elastomorph as em
from characters import shapes, sheet
from elastomorph.character import read_settings, rig_from_settings
from elastomorph.character.schema import tables

PAGE = (Path(__file__).parents[2] / "docs" / "settings.md").read_text()
HEADINGS = {
    "character": "`[character]`",
    "method": "`[method]`",
    "regions.*": "`[regions.NAME]`",
    "inbetweens.*": "`[inbetweens.TARGET]`",
    "correctives.*": "`[correctives.NAME]`",
    "timing": "`[timing]`",
    "export.glb": "`[export.glb]`",
    "export.usd": "`[export.usd]`",
}
ELSEWHERE = {"methods.*", "material"}
"""Tables whose keys are those of [method], or named in one of its lines."""


def test_every_key_stands_in_the_table_of_its_section() -> None:
    assert set(HEADINGS) | ELSEWHERE == set(tables())
    for table, heading in HEADINGS.items():
        section = PAGE.split(f"### {heading}")[1].split("\n#")[0]
        named = set(re.findall(r"^\| `(\w+)` \|", section, re.MULTILINE))
        keys = set(tables()[table])
        if table == "regions.*":
            keys -= set(tables()["method"])
        assert named == keys, table
    assert all(f"`{name}`" in PAGE for name in tables()["material"])


@pytest.mark.filterwarnings("ignore::elastomorph.errors.TimeLawWarning")
def test_its_examples_are_settings(tmp_path: Path) -> None:
    (tmp_path / "shapes").mkdir()
    em.write(tmp_path / "neutral.obj", sheet())
    for name in ("jawOpen", "eyeBlink_L", "eyeBlink_R", "mouthFunnel", "cheekPuff"):
        em.write(tmp_path / "shapes" / f"{name}.obj", shapes()["smile"])
    em.write(tmp_path / "cheekPuff_40.obj", shapes()["brow"])
    (tmp_path / "mouth.json").write_text("[0, 1, 2, 7, 8, 9]")
    examples = re.findall(r"^```toml\n(.*?)^```", PAGE, re.MULTILINE | re.DOTALL)
    assert len(examples) == 3
    for text in examples:
        (tmp_path / "elastomorph.toml").write_text(text)
        settings = read_settings(tmp_path)
        if "[character]" not in text:
            continue
        rig = rig_from_settings(settings, cache=None)
        assert len(rig.morphs) == 5
        assert rig.sliders.groups == {"eyes": ("eyeBlink_L", "eyeBlink_R")}
