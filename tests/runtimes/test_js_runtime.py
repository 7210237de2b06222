"""The package for JavaScript: as Python computes, as three.js and Babylon.js draw it, and small."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path
from typing import Any

import pytest
from engines import require_bent
from kit import RUNTIMES, VECTORS, face, glb_of, require_conforming, require_each_mesh_bent

from elastomorph.io.gltf import write_glb
from foreign_files import chunks_of, glb
from needs import MODULES, WEB, node

JS = RUNTIMES / "js"
FIVE_KB = 5000
POSE = {"jaw": 0.6, "smile": 1.2, "both": -0.3}


def ran(*command: str | Path) -> str:
    done = subprocess.run(
        [*map(str, command)], cwd=WEB, capture_output=True, text=True, timeout=250, check=False
    )
    assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-3000:]
    return done.stdout


def test_it_passes_the_kit() -> None:
    require_conforming([node(), str(JS / "conform.mjs")])


def test_each_mesh_of_a_face_in_materials_is_bent(tmp_path: Path) -> None:
    require_each_mesh_bent([node(), str(JS / "conform.mjs")], tmp_path)


def test_adapters_follow_the_sliders() -> None:
    ran(node(), "--test", Path(__file__).parent / "follower.test.mjs")


@pytest.mark.parametrize("name", ["folds", "laws", "together"])
def test_adapters_allocate_nothing(name: str) -> None:
    ran(node(), Path(__file__).parent / "frames.test.mjs", name)


@pytest.mark.parametrize("player", ["three.js", "Babylon.js"])
class TestEngines:
    """The adapters read the sliders and write the weights; the engine's own sums follow."""

    def test_a_written_file_is_bent(self, player: str, tmp_path: Path) -> None:
        write_glb(tmp_path / "a.glb", face(), tolerance=0)
        require_bent(player, tmp_path / "a.glb", POSE, tmp_path)

    def test_each_mesh_of_a_face_in_materials_is_bent(self, player: str, tmp_path: Path) -> None:
        """As `export` writes them: a mesh a material, with only the targets that move it."""
        write_glb(tmp_path / "a.glb", face(materials=True), tolerance=0)
        assert len(chunks_of(tmp_path / "a.glb")[0]["meshes"]) == 2
        require_bent(player, tmp_path / "a.glb", POSE, tmp_path)

    def test_a_fold_is_followed(self, player: str, tmp_path: Path) -> None:
        path = tmp_path / "a.glb"
        write_glb(path, face(), tolerance=0)
        document, blob = chunks_of(path)
        stored = document["meshes"][0]["extras"]["elastomorph"]
        stored["version"] = max(2, stored["version"])
        stored["morphs"][0]["fold"] = {"breaks": [0, 1], "coefficients": [[0, 0.5, -0.5]]}
        path.write_bytes(glb(document, blob))
        require_bent(player, path, POSE, tmp_path)

    @pytest.mark.parametrize(
        "name", ["other", "correctives", "folds", "indices", "laws", "pairs", "together"]
    )
    def test_the_kit_is_bent(self, player: str, name: str, tmp_path: Path) -> None:
        path = glb_of(VECTORS[name], tmp_path / "v.glb")
        require_bent(player, path, VECTORS[name]["poses"][5]["sliders"], tmp_path)


class TestPackage:
    """What npm would publish."""

    package: dict[str, Any] = json.loads((JS / "package.json").read_text(encoding="utf-8"))

    @pytest.mark.parametrize("module", ["index.js", "three.js", "babylon.js"])
    def test_an_application_grows_by_at_most_5_kb(self, module: str) -> None:
        told = ran(node("vite"), WEB / "checks" / "size.mjs", JS / module)
        assert 1000 < json.loads(told)[str(JS / module)] <= FIVE_KB

    def test_it_needs_nothing(self) -> None:
        assert not {"dependencies", "peerDependencies", "scripts"} & self.package.keys()
        for module in JS.glob("*.js"):
            text = module.read_text("utf-8")
            assert all(
                line.endswith("'./index.js';")
                for line in text.splitlines()
                if "import" in line.split()
            )

    def test_what_it_exports_is_there_with_types(self) -> None:
        for entry in self.package["exports"].values():
            assert (JS / entry["default"]).is_file()
            assert (JS / entry["types"]).is_file()

    def test_it_is_imported_by_its_name(self) -> None:
        """A package may import itself, as others would."""
        names = ["", "/three", "/babylon"]
        program = "".join(f"await import('elastomorph{name}');" for name in names)
        command = [node(), "--input-type=module", "--eval", program]
        done = subprocess.run(command, cwd=JS, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr

    def test_typed_programs_compile(self, tmp_path: Path) -> None:
        program = node("typescript", "three", "@babylonjs/core")
        ran(program, MODULES / "typescript" / "bin" / "tsc", "--noEmit", "-p", WEB / "checks")
