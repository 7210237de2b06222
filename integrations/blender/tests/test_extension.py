"""The .zip: what Blender's own tools make of it, and what is in it."""

import subprocess
import sys
import zipfile
from pathlib import Path

import bpy
import pytest


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
