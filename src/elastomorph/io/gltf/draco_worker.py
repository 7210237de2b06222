"""Unpacks streams of Draco, in a process that may crash."""

from __future__ import annotations

from typing import Any

from numpy.typing import NDArray

from elastomorph.io.isolated import RefusedError, serve
from elastomorph.io.npz.members import open_npz


def content_of(source: str) -> dict[str, NDArray[Any]]:
    """The triangles and attributes of all streams in an archive, by stream and number."""
    found: dict[str, NDArray[Any]] = {}
    with open_npz(source) as streams:
        for name in sorted(streams.names):
            mesh = _mesh(name, streams.array(name, "u", (None,)).tobytes())
            found[f"{name}.triangles"] = mesh.faces
            for attribute in mesh.attributes:
                found[f"{name}.{attribute['unique_id']}"] = attribute["data"]
    return found


def _mesh(name: str, stream: bytes) -> Any:
    import DracoPy

    problem = "holds no triangles"
    try:
        mesh = DracoPy.decode(stream)
    except MemoryError:
        raise
    except Exception as error:  # the library raises several of its own, and plain ones
        problem = f"is damaged ({str(error)[:100]})"
    else:
        if isinstance(mesh, DracoPy.DracoMesh):
            return mesh
    raise RefusedError(f"buffer view {name}, packed with Draco, {problem}")


def _prepare() -> None:
    import DracoPy  # noqa: F401


if __name__ == "__main__":
    serve(_prepare, content_of)
