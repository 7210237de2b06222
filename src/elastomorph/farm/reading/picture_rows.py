"""Pictures of a data set with what is to be learned from them, face by face."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from numpy.typing import NDArray

from elastomorph.errors import ParameterError
from elastomorph.farm.reading.rows import Rows
from elastomorph.farm.storage.contents import IMAGES

if TYPE_CHECKING:
    from elastomorph.farm.reading.faces import FaceSet


def pictured(faces: FaceSet) -> dict[str, Rows]:
    """The arrays of the pictures that are stored, by their names without the folder."""
    return {
        name.removeprefix(IMAGES): rows
        for name, rows in faces.labels.items()
        if name.startswith(IMAGES)
    }


class PictureRows:
    """``pictures[7]`` is a dict of what is stored of face 7, ``pictures[10:20]`` of ten of them.

    Keys are ``weights`` ((J,) float64 of the rig's sliders) and the arrays of the pictures without
    their folder, as they are stored: ``colour`` ((H, W, 3) uint8 sRGB), ``depth``, ``normals``,
    ``parts``, ``landmarks``, ``camera``, ``head``, ``intrinsics``. What is asked for by several
    numbers has one more axis in front.

    Attributes:
        arrays: The same by name, each to be sliced by itself; `Rows.attributes` say what they mean.
    """

    def __init__(self, faces: FaceSet) -> None:
        found = pictured(faces)
        if not found:
            raise ParameterError(
                f"{faces.data.order.url} holds no pictures; data sets made with  --render 256  do"
            )
        self.arrays: Mapping[str, Rows] = found | {"weights": faces.weights}

    def __len__(self) -> int:
        return len(self.arrays["weights"])

    def __getitem__(self, index: Any) -> dict[str, NDArray[Any]]:
        return {name: rows[index] for name, rows in self.arrays.items()}

    def __iter__(self) -> Iterator[dict[str, NDArray[Any]]]:
        return (self[number] for number in range(len(self)))
