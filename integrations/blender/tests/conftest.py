"""Blender as a module, with the extension installed as people install it, from the built .zip."""

import atexit
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

# Blender reads this once, when it is first imported: nothing of the user's own Blender is touched.
_RESOURCES = tempfile.mkdtemp(prefix="elastomorph-blender-")
atexit.register(shutil.rmtree, _RESOURCES, ignore_errors=True)
os.environ["BLENDER_USER_RESOURCES"] = _RESOURCES

import bpy  # noqa: E402

_BUILD = Path(__file__).parent.parent / "build.py"


@pytest.fixture(scope="session")
def extension() -> Path:
    """The .zip, built for this system."""
    built = subprocess.run(
        [sys.executable, str(_BUILD), "-o", _RESOURCES, "--platform", _platform()],
        check=True,
        stdout=subprocess.PIPE,
        text=True,
    )
    return Path(built.stdout.strip())


@pytest.fixture(scope="session", autouse=True)
def installed(extension: Path) -> None:
    """The extension, installed by Blender's own installer and enabled."""
    assert "FINISHED" in bpy.ops.extensions.package_install_files(
        filepath=str(extension), repo="user_default", enable_on_install=True
    )
    # Readers that run in processes of their own, such as that of FBX, start from the same package.
    import elastomorph

    os.environ["PYTHONPATH"] = str(Path(elastomorph.__file__).parent.parent)


@pytest.fixture(autouse=True)
def empty_scene(installed: None) -> None:
    """Nothing in the scene before a test."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)


def _platform() -> str:
    if sys.platform == "win32":
        return "windows-x64"
    if sys.platform == "darwin":
        return "macos-arm64" if os.uname().machine == "arm64" else "macos-x64"
    return "linux-x64"
