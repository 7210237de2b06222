"""Takes on a page: opened, and read back from its state."""

from __future__ import annotations

import base64
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from visiting import settled, wait

import elastomorph as em
import streams
from elastomorph.rig import Rig
from elastomorph.viewer import Scene, SceneModel

if TYPE_CHECKING:
    from playwright.sync_api import Page

LATEST = """number => {
    const take = elastomorph.state().takes.at(number);
    const text = numbers => {
        const bytes = new Uint8Array(numbers.slice().buffer);
        let letters = '';
        for (let i = 0; i < bytes.length; i += 8192)
            letters += String.fromCharCode(...bytes.subarray(i, i + 8192));
        return btoa(letters);
    };
    const tracks = [...take.tracks].map(([slider, track]) => [slider, text(track)]);
    return {name: take.name, times: text(take.times), tracks: Object.fromEntries(tracks)};
}"""

# Whether somebody who leaves the page is asked.
ASKS = """(() => {
    const leaving = new Event('beforeunload', {cancelable: true});
    dispatchEvent(leaving);
    return leaving.defaultPrevented;
})()"""

# From now on the browser keeps nothing more of takes.
NO_ROOM = """() => {
    IDBObjectStore.prototype.put = () => {
        throw new DOMException('There is no room.', 'QuotaExceededError');
    };
}"""

# What the browser keeps of takes: of each, its head and the names of its parts.
SHELF = """rig => new Promise((done, fail) => {
    const opening = indexedDB.open('elastomorph');
    opening.onerror = () => fail(opening.error);
    opening.onsuccess = () => {
        const database = opening.result;
        if (!database.objectStoreNames.contains('takes')) return database.close(), done([]);
        const store = database.transaction('takes').objectStore('takes');
        const [keys, values] = [store.getAllKeys(), store.getAll()];
        values.onsuccess = () => {
            const found = {};
            keys.result.forEach(([own, id, part], i) => {
                if (own.replace(/, \\d+$/, '') !== 'elastomorph ' + rig) return;
                const take = (found[own + id] ??= {key: [own, id], parts: []});
                take.parts.push(String(part));
                if (part === 0) Object.assign(take, values.result[i]);
            });
            database.close();
            done(Object.values(found));
        };
    };
})"""


class Take(NamedTuple):
    """What a page made of a take: (T,) seconds, and (T,) weights of each slider it drives."""

    name: str
    times: NDArray[np.float64]
    tracks: dict[str, NDArray[np.float32]]


def open_files(page: Page, *files: Path) -> None:
    """Chooses files as in the browser's dialogue, and waits until they are open or refused."""
    page.locator("input[aria-label='Files to open']").set_input_files([str(f) for f in files])
    settled(page)
    wait(page, "document.querySelector('.busy').textContent === ''")
    settled(page)


def latest(page: Page, number: int = -1) -> Take:
    """The take that was opened or edited last, or another one by its number."""
    found = page.evaluate(LATEST, number)

    def numbers(text: str) -> NDArray[np.float32]:
        return np.frombuffer(base64.b64decode(text), "<f4")

    tracks = {name: numbers(text) for name, text in found["tracks"].items()}
    return Take(found["name"], np.frombuffer(base64.b64decode(found["times"]), "<f8"), tracks)


def page_title(page: Page) -> str:
    found: str = page.evaluate("document.querySelector('h1').textContent")
    return found


def shelf(page: Page, rig: str = "") -> list[dict[str, Any]]:
    """What the browser keeps of the takes of a rig, that of the page by default."""
    found: list[dict[str, Any]] = page.evaluate(SHELF, rig or page_title(page))
    return found


def kept(page: Page, holds: Callable[[list[dict[str, Any]]], bool] = lambda _: True) -> None:
    """Waits until the browser keeps all takes of a page as they are, and that holds for them."""

    def there() -> bool:
        names = page.evaluate("elastomorph.state().takes.map(({name}) => name).sort()")
        found = shelf(page)
        same = sorted(one.get("name", "") for one in found) == names
        return same and not page.evaluate(ASKS) and holds(found)

    streams.wait(there)


def told(page: Page) -> list[str]:
    """What the page has told people and they have not dismissed, and takes it away."""
    messages = page.locator(".message")
    words = [text.strip() for text in messages.all_inner_texts()]
    page.evaluate("document.querySelectorAll('.message button').forEach(b => b.click())")
    return words


def named_rig(names: tuple[str, ...]) -> Rig:
    """A rig of a few vertices with a slider of each name."""
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]], float)
    neutral = em.Mesh(corners, [[0, 1, 3, 2]])
    to = em.prepare(neutral, "linear")
    return Rig(neutral, {name: to(_moved(neutral, i)) for i, name in enumerate(names)})


def _moved(neutral: em.Mesh, i: int) -> em.Mesh:
    moved = neutral.vertices.copy()
    moved[i % 4, 2] += 0.1 + 0.01 * i
    return neutral.with_vertices(moved)


def alone(glb: bytes, name: str = "rig") -> Scene:
    return Scene((SceneModel(name, "rig", glb),), name)
