"""What a data set would take: bytes and time, from a second of making it on this machine."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from pathlib import Path

from elastomorph.blas_threads import usable_cores
from elastomorph.farm.making.executors import make_units, rate_text, size_text, time_text
from elastomorph.farm.making.run import begun, unit_size
from elastomorph.farm.sampling.sampler import FaceSampler
from elastomorph.farm.storage.contents import TOGETHER, Label
from elastomorph.farm.storage.manifest import NAME
from elastomorph.farm.storage.stores import Order, naming_store
from elastomorph.farm.storage.wanted import Wanted
from elastomorph.io.atomic import temporary_folder
from elastomorph.numbers import power_of_two
from elastomorph.rig.rig import Rig

_SECONDS = 1.0
_PIXELS = 2**21  # Drawn in some seconds


@dataclass(frozen=True)
class Estimate:
    """What a data set would take on machines such as this one.

    Attributes:
        faces: How many were asked for.
        bytes: Stored in all.
        objects: Files, or objects of a store.
        seconds: On this machine alone.
        cores: Of this machine.
        tried: Faces made in the trial.
    """

    faces: int
    bytes: float
    objects: int
    seconds: float
    cores: int
    tried: int

    def told(self) -> dict[str, str]:
        """Its facts for people."""
        return {
            "faces": f"{self.faces:,}",
            "bytes": f"{size_text(self.bytes)} in {self.objects:,} objects",
            "time": f"{time_text(self.seconds)} on {self.cores} cores, "
            f"{rate_text(self.faces / self.seconds)} faces a second",
            "from": f"a trial of {self.tried:,} faces on this machine",
        }


def estimate(rig: Rig, sampler: FaceSampler, faces: int | None, wanted: Wanted) -> Estimate:
    """Make faces for a second, in a data set that is thrown away, and count on from there.

    Args:
        rig: The rig.
        sampler: The recipe at work.
        faces: How many it would be.
        wanted: What is stored.

    Raises:
        FileError: Where the system keeps temporary files, there is no room.
        ParameterError: As for `elastomorph.make_faces`.
    """
    tried_with = wanted
    if (pictures := sampler.recipe.pictures) is not None:  # whose units take longer than a second
        some = power_of_two(min(TOGETHER, _PIXELS // pictures.size**2))
        tried_with = replace(wanted, unit=some)
    with temporary_folder() as folder:
        order = Order(str(folder / "trial.zarr"))
        with naming_store(order):
            data = begun(order, rig, sampler, faces, tried_with)
            data.prepare()
            start, tried, size = time.perf_counter(), 0, 0
            for made in make_units(data, range(data.manifest.units)):
                tried, size = tried + made.faces, size + made.bytes
                if (spent := time.perf_counter() - start) > _SECONDS:
                    break
            once = _kept_once(Path(order.url), {*data.plan.arrays, NAME})
    labels = {name: own for content in data.contents for name, own in content.labels.items()}
    labels |= {"weights": Label((len(data.columns),), "uint16")}
    units = -(-data.faces // (wanted.unit or unit_size(labels, data.contents)))
    arrays = len(data.plan.arrays)
    return Estimate(
        data.faces,
        sum(once) + units * 8 * (1 + 2 * arrays) + size / tried * data.faces,
        units * (1 + arrays) + len(once),
        data.faces / tried * spent,
        usable_cores(),
        tried,
    )


def _kept_once(folder: Path, by_unit: set[str]) -> list[int]:
    """Bytes of each file that does not grow with the faces: metadata, rig, neutral, takes."""
    files = {f.relative_to(folder): f for f in folder.rglob("*") if f.is_file()}
    return [
        file.stat().st_size
        for name, file in files.items()
        if name.parent.as_posix() not in by_unit or not name.name.startswith("c.")
    ]
