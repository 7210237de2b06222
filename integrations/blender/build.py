"""Build the extension: one .zip that Blender installs from disk.

    python integrations/blender/build.py -o out/blender

The wheels of elastomorph and of what it imports are in it, for the systems that are asked for;
Blender takes those of its own system and brings NumPy itself. pip fetches them at the versions in
``wheels.txt``, and hatchling, which must be installed, builds the one of elastomorph.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
import tomllib
import zipfile
from collections.abc import Sequence
from pathlib import Path

HERE = Path(__file__).parent
ROOT = HERE.parent.parent
SOURCE = HERE / "elastomorph_blender"

PYTHON = "3.11"
"""The Python of the versions of Blender in the manifest."""

PLATFORMS = {
    "linux-x64": ("manylinux2014_x86_64", "manylinux_2_27_x86_64", "manylinux_2_28_x86_64"),
    "macos-arm64": ("macosx_11_0_arm64", "macosx_12_0_arm64"),
    "macos-x64": ("macosx_10_9_x86_64", "macosx_10_14_x86_64"),
    "windows-x64": ("win_amd64",),
}
"""What Blender calls a system, and what wheels call it."""

# The same bytes whenever the same is built.
_DATE = (2020, 1, 1, 0, 0, 0)


def build(folder: Path, platforms: Sequence[str]) -> Path:
    """The extension as a .zip in a folder, with wheels for these systems."""
    manifest = (SOURCE / "blender_manifest.toml").read_text(encoding="utf-8")
    entries = tomllib.loads(manifest)
    if entries["version"] != _version():
        raise SystemExit(f"the manifest says {entries['version']}, the package {_version()}")
    folder.mkdir(parents=True, exist_ok=True)
    suffix = f"-{platforms[0]}" if len(platforms) == 1 else ""
    made = folder / f"{entries['id']}-blender-{entries['version']}{suffix}.zip"
    with tempfile.TemporaryDirectory() as temporary:
        wheels = _wheels(Path(temporary), platforms)
        # Before the first table, where a value of the whole file must stand.
        listed = (
            f"platforms = {_texts(platforms)}\n"
            f"wheels = {_texts([f'./wheels/{wheel.name}' for wheel in wheels])}\n\n"
        )
        head, table, rest = manifest.partition("[permissions]")
        half = made.with_suffix(".part")
        with zipfile.ZipFile(half, "w", zipfile.ZIP_DEFLATED) as archive:
            _add(archive, "blender_manifest.toml", (head + listed + table + rest).encode())
            for source in sorted(SOURCE.glob("*.py")):
                _add(archive, source.name, source.read_bytes())
            _add(archive, "LICENSE", (ROOT / "LICENSE").read_bytes())
            for wheel in wheels:
                _add(archive, f"wheels/{wheel.name}", wheel.read_bytes(), zipfile.ZIP_STORED)
        half.replace(made)
    return made


def _version() -> str:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    return str(project["project"]["version"])


def _wheels(folder: Path, platforms: Sequence[str]) -> list[Path]:
    """The wheel of elastomorph, and those of what it imports."""
    _run("-m", "hatchling", "build", "-t", "wheel", "-d", str(folder))
    for platform in platforms:
        tags = (f"--platform={tag}" for tag in PLATFORMS[platform])
        _run(
            *("-m", "pip", "download", "--quiet", "--disable-pip-version-check", "--no-deps"),
            *("--only-binary=:all:", f"--python-version={PYTHON}", *tags),
            *("--dest", str(folder), "--requirement", str(HERE / "wheels.txt")),
        )
    return sorted(folder.glob("*.whl"))


def _run(*arguments: str) -> None:
    subprocess.run([sys.executable, *arguments], check=True, cwd=ROOT, stdout=sys.stderr)


def _texts(values: Sequence[str]) -> str:
    lines = "".join(f'  "{value}",\n' for value in values)
    return f"[\n{lines}]"


def _add(
    archive: zipfile.ZipFile, name: str, content: bytes, how: int = zipfile.ZIP_DEFLATED
) -> None:
    entry = zipfile.ZipInfo(name, _DATE)
    entry.external_attr = 0o644 << 16
    archive.writestr(entry, content, how)


def main() -> None:
    """Build it where the command line says."""
    parser = argparse.ArgumentParser(description="Build the extension for Blender.")
    parser.add_argument("-o", "--output", type=Path, default=ROOT / "out" / "blender")
    parser.add_argument(
        "--platform",
        action="append",
        choices=[*PLATFORMS],
        help="only for this system, which may be given more than once; all by default",
    )
    asked = parser.parse_args()
    print(build(asked.output.resolve(), asked.platform or [*PLATFORMS]))


if __name__ == "__main__":
    main()
