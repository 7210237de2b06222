"""How fast the viewer's page loads and draws, beside a plain three.js page; its picture for README.

Run:  python benchmarks/viewer.py [--data FOLDER] [--frames 40] [--picture docs/viewer.png]

Prints, measured in one run in one Chromium that draws in software: the size of both pages, the
time from opening a file on disk to its first frame, and the shortest time of a frame with every
slider at random and with one slider, for a production rig. The plain page is what users of three.js
write: its own loader and morph targets, built here in a temporary folder, with one straight target
an expression; the viewer also adds the bends, finds normals on every frame, and a shadow now and
then. Frames are those of a slider that is dragged, the interface included. With --picture only the
picture is made.
"""

from __future__ import annotations

import argparse
import base64
import io
import os
import shutil
import subprocess
import tempfile
from pathlib import Path
from typing import Any

from PIL import Image, ImageOps

import elastomorph as em
from elastomorph.io import read_rig
from elastomorph.io.gltf import write_glb
from elastomorph.rig import Rig
from elastomorph.samples import recorded_motion
from elastomorph.viewer import Scene, evaluation_scene, rig_scene, write_viewer
from elastomorph.viewer.page import shipped_page
from measuring import data_folder

WEB = Path(__file__).resolve().parents[1] / "web"
LIMIT_BYTES, LIMIT_SECONDS, LIMIT_PICTURE = 900_000, 2.0, 400_000
WINDOW = {"width": 1280, "height": 720}
ARGUMENTS = [
    "--disable-gpu",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
]

PLAIN_PAGE = """<!doctype html>
<html lang="en">
  <head>
    <meta charset="utf-8" />
    <title>plain</title>
    <link rel="icon" href="data:," />
    <!-- face -->
    <script type="module" src="./main.js"></script>
  </head>
  <body style="margin: 0"></body>
</html>
"""

PLAIN_SCRIPT = """
import {
  AmbientLight, Box3, DirectionalLight, PerspectiveCamera, Scene, Vector3, WebGLRenderer,
} from 'three';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';

const [width, height] = document.documentElement.dataset.size.split(' ').map(Number);
const renderer = new WebGLRenderer({ antialias: true });
renderer.setSize(width, height);
document.body.append(renderer.domElement);

async function start() {
  const text = document.getElementById('face').textContent;
  const bytes = await (await fetch('data:application/octet-stream;base64,' + text)).arrayBuffer();
  const face = (await new GLTFLoader().parseAsync(bytes, '')).scene;
  const scene = new Scene();
  const light = new DirectionalLight(0xffffff, 2);
  light.position.set(1, 1, 2);
  scene.add(face, new AmbientLight(0xffffff, 1), light);
  const meshes = [];
  face.traverse((one) => { if (one.morphTargetInfluences) meshes.push(one); });
  const box = new Box3().setFromObject(face);
  const [middle, size] = [box.getCenter(new Vector3()), box.getSize(new Vector3())];
  const camera = new PerspectiveCamera(24, width / height, 0.1 * size.y, 20 * size.y);
  camera.position.copy(middle).add(new Vector3(0, 0, 2.9 * size.y));
  const draw = () => renderer.render(scene, camera);
  draw();
  return { meshes, draw };
}

const ready = start();
window.plain = {
  ready,
  async targets() { return (await ready).meshes[0].morphTargetInfluences.length; },
  async poser() {
    const { meshes, draw } = await ready;
    return (weights) => {
      for (const { morphTargetInfluences } of meshes) {
        for (let i = 0; i < weights.length; i += 1) morphTargetInfluences[i] = weights[i];
      }
      draw();
    };
  },
};
"""

PLAIN_BUILD = """
import { viteSingleFile } from 'vite-plugin-singlefile';
export default {
  plugins: [viteSingleFile({ removeViteModuleLoader: true })],
  logLevel: 'error',
  build: { target: 'es2022', modulePreload: false },
};
"""

# Reading a pixel waits until everything before it is drawn.
FINISH = """const nextFrame = requestAnimationFrame.bind(window);
const finish = () => {
    const gl = document.querySelector('canvas').getContext('webgl2');
    gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
};"""
OUR_POSER = """const names = (await elastomorph.ready, pageSliders);
// Frames are drawn when they are asked for, as while a slider is dragged.
const waiting = [];
window.requestAnimationFrame = (draw) => waiting.push(draw);
const pose = (weights) => {
    elastomorph.update({ weights: Object.fromEntries(names.map((n, i) => [n, weights[i]])) });
    const due = waiting.splice(0);
    for (const draw of due) draw(performance.now());
};"""
PLAIN_POSER = "const pose = await plain.poser();"
FRAMES = """
const random = (count) => Array.from({ length: sliders }, (_, i) => i < count ? Math.random() : 0);
const times = (count) => {
    const found = [];
    for (let i = 0; i < frames + 2; i += 1) {
        const weights = random(count);
        const start = performance.now();
        pose(weights);
        finish();
        found.push(performance.now() - start);
    }
    return Math.min(...found.slice(2));
};
const live = async (seconds) => {
    let count = 0;
    const start = performance.now();
    while (performance.now() - start < 1000 * seconds) {
        pose(random(sliders));
        await new Promise(nextFrame);
        count += 1;
    }
    return (1000 * seconds) / count;
};
return { all: times(sliders), one: times(1), live: await live(4) };
"""


def chromium() -> str:
    found = os.environ.get("ELASTOMORPH_CHROMIUM") or shutil.which("chromium")
    if found is None:
        raise SystemExit("there is no chromium; name one in ELASTOMORPH_CHROMIUM")
    return found


def build_plain(folder: Path) -> str:
    """The plain page without a face."""
    (folder / "index.html").write_text(PLAIN_PAGE)
    (folder / "main.js").write_text(PLAIN_SCRIPT)
    (folder / "vite.config.mjs").write_text(PLAIN_BUILD)
    (folder / "node_modules").symlink_to(WEB / "node_modules")
    vite = WEB / "node_modules" / ".bin" / "vite"
    if not vite.exists():
        raise SystemExit("the plain page is built with vite: run npm ci --prefix web")
    subprocess.run([vite, "build"], cwd=folder, check=True, stdout=subprocess.DEVNULL)
    return (folder / "dist" / "index.html").read_text(encoding="utf-8")


def glb(rig: Rig) -> bytes:
    file = io.BytesIO()
    write_glb(file, rig, normals="none")
    return file.getvalue()


def opened(browser: Any, file: Path, ready: str) -> tuple[Any, float]:
    """A page from disk, and the seconds until its first frame was drawn."""
    page = browser.new_context(viewport=WINDOW, reduced_motion="reduce").new_page()
    page.goto(file.as_uri(), wait_until="commit")
    while not page.evaluate(f"typeof {ready.partition('.')[0]} !== 'undefined'"):
        pass
    milliseconds = page.evaluate(
        f"(async () => {{ {FINISH} await {ready}; finish(); return performance.now(); }})()"
    )
    return page, milliseconds / 1000


def loaded(browser: Any, file: Path, ready: str, repeats: int = 5) -> tuple[Any, float]:
    """The page opened last, and the shortest of several loads."""
    times = []
    for _ in range(repeats):
        page, seconds = opened(browser, file, ready)
        times.append(seconds)
        if len(times) < repeats:
            page.context.close()
    return page, min(times)


def frames(page: Any, poser: str, sliders: list[str], count: int) -> dict[str, float]:
    script = (
        f"async ([pageSliders, frames]) => {{ const sliders = pageSliders.length; {FINISH} "
        f"{poser} {FRAMES} }}"
    )
    found: dict[str, float] = page.evaluate(script, [sliders, count])
    return found


def measure(browser: Any, folder: Path, count: int) -> None:
    linear = read_rig(folder, method="linear")
    to = em.prepare(linear.neutral, "beam:2")
    curved = Rig(linear.neutral, {n: to(m.target) for n, m in linear.morphs.items()})
    bends = sum(len(morph.bends) for morph in curved.morphs.values())
    names = list(curved.names)
    print(
        f"{folder.name}: {len(linear.neutral.vertices):,} vertices, {len(names)} sliders, "
        f"{bends} bends; {os.cpu_count()} cores"
    )
    with tempfile.TemporaryDirectory() as scratch:
        ours = Path(scratch) / "viewer.html"
        write_viewer(ours, rig_scene(curved, unit="cm"))
        page, our_load = loaded(browser, ours, "elastomorph.ready")
        print(f"  drawn by {renderer(page)}, Chromium {browser.version}")
        box = page.locator("canvas").first.bounding_box()
        our_frames = frames(page, OUR_POSER, names, count)
        readout = page.evaluate("elastomorph.readout()")
        page.context.close()
        empty = build_plain(Path(scratch))
        face = base64.b64encode(glb(linear)).decode()
        block = f'<script type="application/octet-stream" id="face">{face}</script>'
        size = f"{box['width']:.0f} {box['height']:.0f}"
        text = empty.replace("<!-- face -->", block)
        plain = Path(scratch) / "plain.html"
        plain.write_text(text.replace("<html", f'<html data-size="{size}"', 1), encoding="utf-8")
        page, plain_load = loaded(browser, plain, "plain.ready")
        assert page.evaluate("plain.targets()") == len(names)
        plain_frames = frames(page, PLAIN_POSER, names, count)
        page.context.close()
        files = [file.stat().st_size / 1e6 for file in (ours, plain)]

    def row(what: str, one: float, other: float, unit: str, limit: str = "") -> None:
        print(f"  {what:<38}{one:9.3g} {unit:<3}{other:9.3g} {unit:<3}{limit}")

    print(f"{'':40}{'viewer':>9}    {'plain three.js':>14}")
    shipped = len(shipped_page().encode())
    row("page without a face", shipped / 1e3, len(empty.encode()) / 1e3, "kB", "(limit 900 kB)")
    row("page with the face", *files, "MB")
    row("opened from disk, to the first frame", our_load, plain_load, "s", "(limit 2 s)")
    row("frame, every slider at random", our_frames["all"], plain_frames["all"], "ms")
    row("frame, one slider", our_frames["one"], plain_frames["one"], "ms")
    row("… of the whole page, every slider", our_frames["live"], plain_frames["live"], "ms")
    print(
        f"  picture of {size.replace(' ', ' × ')} pixels; the viewer adds {readout['targets']} "
        f"targets, {readout['mebibytes']:.0f} MiB, the plain page {len(names)}"
    )
    for missed, words in (
        (shipped > LIMIT_BYTES, "the page is too large"),
        (our_load > LIMIT_SECONDS, "the page loads too slowly"),
    ):
        if missed:
            print(f"  MISSED: {words}")


def renderer(page: Any) -> str:
    found: str = page.evaluate(
        """() => {
            const gl = document.querySelector('canvas').getContext('webgl2');
            const names = gl.getExtension('WEBGL_debug_renderer_info');
            return gl.getParameter(names ? names.UNMASKED_RENDERER_WEBGL : gl.RENDERER);
        }"""
    )
    return "SwiftShader, in software" if "SwiftShader" in found else found


def telling_scene() -> tuple[Scene, int]:
    """The recorded jaw beside the straight line and the nearest method; the vertex worst off."""
    motion = recorded_motion()
    evaluation = em.evaluate(motion, ["linear", "rotation"])
    straight = evaluation.results[0].morph
    half = int(abs(motion.times - 0.5).argmin())
    apart = ((straight.at(float(motion.times[half])) - motion[half].vertices) ** 2).sum(axis=1)
    return evaluation_scene(evaluation, title="Recorded jaw, half way", unit="cm"), int(
        apart.argmax()
    )


def draw_picture(browser: Any, file: Path) -> None:
    scene, worst = telling_scene()
    with tempfile.TemporaryDirectory() as scratch:
        page_file = Path(scratch) / "picture.html"
        write_viewer(page_file, scene)
        page, _ = opened(browser, page_file, "elastomorph.ready")
        page.get_by_role("tab", name="Compare").click()
        start = {"picked": [worst], "orbits": True, "theme": "dark"}
        page.evaluate("patch => elastomorph.update(patch)", start)
        page.evaluate("elastomorph.look('three-quarter')")
        page.wait_for_timeout(2000)  # until the figures are written
        png = page.screenshot()
        page.context.close()
    with Image.open(io.BytesIO(png)) as image:
        # Seven bits of colour look the same and take three quarters of the room.
        ImageOps.posterize(image.convert("RGB"), 7).save(file, optimize=True)
    size = file.stat().st_size
    print(f"{file}: {size / 1e3:.0f} kB (limit {LIMIT_PICTURE / 1e3:.0f} kB)")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--data", type=Path, default=data_folder())
    parser.add_argument("--frames", type=int, default=40)
    parser.add_argument("--picture", type=Path, help="only make this picture (.png)")
    options = parser.parse_args()
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=chromium(), args=ARGUMENTS, chromium_sandbox=False
        )
        if options.picture is not None:
            draw_picture(browser, options.picture)
        elif (options.data / "ict-facekit").is_dir():
            measure(browser, options.data / "ict-facekit", options.frames)
        else:
            print(f"no folder {options.data / 'ict-facekit'}: nothing to measure")
        browser.close()


if __name__ == "__main__":
    main()
