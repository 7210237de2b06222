"""The .zip: what Blender's own tools make of it, and what is in it."""

import subprocess
import sys
import zipfile
from pathlib import Path
from types import SimpleNamespace

import bpy
import pytest
from heads import add_head, small_head


def blenders_tool(*arguments: str) -> subprocess.CompletedProcess:
    """Blender's command for extensions, which checks what its platform would check."""
    (tool,) = Path(bpy.utils.system_resource("SCRIPTS")).glob(
        "addons_core/bl_pkg/cli/blender_ext.py"
    )
    return subprocess.run(
        [sys.executable, str(tool), *arguments], capture_output=True, text=True, check=False
    )


def test_blender_finds_the_extension_valid(extension):
    done = blenders_tool("validate", str(extension))
    assert done.returncode == 0, done.stdout + done.stderr
    assert "FATAL" not in done.stdout
    assert "ERROR" not in done.stdout


def test_all_that_is_imported_came_with_it():
    import scipy

    import elastomorph

    own = Path(bpy.utils.user_resource("EXTENSIONS")).resolve()
    for module in (elastomorph, scipy):
        assert own in Path(module.__file__).resolve().parents
    for module in ("matplotlib", "vtkmodules", "jinja2", "rich", "typer"):
        assert module not in sys.modules


def test_it_holds_no_more_than_it_should(extension):
    with zipfile.ZipFile(extension) as archive:
        names = archive.namelist()
    assert "LICENSE" in names
    assert sum(name.startswith("wheels/") for name in names) == 3
    assert not [name for name in names if "__pycache__" in name or "tests" in name]


def test_it_is_disabled_and_enabled_again():
    module = "bl_ext.user_default.elastomorph"
    assert "DATA_PT_elastomorph" in dir(bpy.types)
    bpy.ops.preferences.addon_disable(module=module)
    assert "DATA_PT_elastomorph" not in dir(bpy.types)
    assert not hasattr(bpy.types.Object, "elastomorph_preview")
    with pytest.raises(AttributeError):
        bpy.ops.elastomorph.bend()
    bpy.ops.preferences.addon_enable(module=module)
    assert "DATA_PT_elastomorph" in dir(bpy.types)


def test_the_panel_offers_what_there_is():
    """It is drawn with a layout that notes what it is asked for."""
    import importlib

    head = add_head(small_head("jawOpen"))
    head.active_shape_key_index = 1
    panel = importlib.import_module("bl_ext.user_default.elastomorph.panel").ShapeKeyBends
    assert panel.poll(bpy.context)
    asked = Layout()
    panel.draw(SimpleNamespace(layout=asked), bpy.context)
    for name in asked.operators:
        group, _, operator = name.partition(".")
        assert getattr(getattr(bpy.ops, group), operator).poll()
    assert len(asked.operators) == 5
    assert asked.labels == ["0 bends of 0 keys"]
    assert asked.properties == ["elastomorph_preview"]
    bpy.ops.elastomorph.bend()
    panel.draw(SimpleNamespace(layout=asked), bpy.context)
    assert asked.labels[1:] == ["2 bends of 1 keys"]


class Layout:
    """What a panel asks of its layout, rows and columns alike."""

    def __init__(self):
        self.operators, self.properties, self.labels = [], [], []

    def row(self, align=False):
        return self

    column = row

    def operator(self, name, text="", icon="NONE"):
        self.operators.append(name)

    def prop(self, owner, name, slider=False):
        assert name in owner.bl_rna.properties
        self.properties.append(name)

    def label(self, text=""):
        self.labels.append(text)
