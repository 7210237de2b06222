"""Renders photographs of a head whose truth is known, with the truth beside them.

    python tools/render_photographs.py FOLDER [--small] [--subject small|ict] [--poses 11] …

``--small`` is two poses in 12 photographs of 750 x 1000 from the front. A folder a pose is written,
``template.obj`` (another person's face), ``truth.npz`` (`photographs.truth`) and ``poses_true/``.
The same options give the same photographs. Needs the extra ``capture``; the subject ``ict`` also
the real rig in ``ELASTOMORPH_DATA``.
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import replace
from functools import partial
from pathlib import Path

import cv2
import numpy as np

from photographs.backdrop import BACKDROPS
from photographs.film import Film
from photographs.sessions import SMALL, Session, photograph
from photographs.subjects import SUBJECTS

SHOWN = (150, 200)


def options(arguments: list[str] | None = None) -> argparse.Namespace:
    """The command line; what is not given is as the session has it."""
    parser = argparse.ArgumentParser(
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        argument_default=argparse.SUPPRESS,
    )
    parser.add_argument("folder")
    parser.add_argument("--small", action="store_true", default=False)
    parser.add_argument("--subject", choices=list(SUBJECTS))
    parser.add_argument("--movement", help="smile, pucker, sneer; recorded (small)")
    parser.add_argument("--poses", type=int)
    parser.add_argument("--count", type=int, help="photographs of each pose")
    parser.add_argument("--size", type=int, nargs=2, metavar=("WIDTH", "HEIGHT"))
    parser.add_argument("--rings", type=float, nargs="+", help="elevations in degrees")
    parser.add_argument("--azimuth", type=float, help="to either side, in degrees")
    parser.add_argument("--rig", choices=["walking", "fixed"])
    parser.add_argument("--motion", type=float, help="of the head between poses, in degrees")
    parser.add_argument("--sway", type=float, help="of the head between photographs, in degrees")
    parser.add_argument("--drift", type=float, help="of the face between photographs, of t")
    parser.add_argument("--jitter", type=float, help="of cameras: 1 by hand, 0 exact")
    parser.add_argument("--texture", type=float, help="strength of the skin's, 1 unless told")
    parser.add_argument("--radial", type=float, help="k1 of the lens")
    parser.add_argument("--backdrop", choices=BACKDROPS)
    parser.add_argument("--seed", type=int)
    parser.add_argument("--sheet", help="also a picture of what was taken: .jpg or .png")
    film = parser.add_argument_group("film")
    film.add_argument("--blur", type=float, help="in pixels of a photograph 2000 high")
    film.add_argument("--noise", type=float, help="of a value of 0 to 1")
    film.add_argument("--exposure", type=float, help="change between photographs, relative")
    film.add_argument("--quality", type=int, help="of JPEG")
    film.add_argument("--orientation", type=int, choices=[1, 3, 6, 8], help="as EXIF has it")
    film.add_argument("--no-exif", dest="exif", action="store_false")
    return parser.parse_args(arguments)


def session_of(chosen: argparse.Namespace) -> Session:
    """The session that options describe."""
    given = {key: tuple(v) if isinstance(v, list) else v for key, v in vars(chosen).items()}
    base = SMALL if given.pop("small") else Session()
    del given["folder"]
    given.pop("sheet", None)
    film = {key: given.pop(key) for key in list(given) if key in Film.__dataclass_fields__}
    return replace(base, film=replace(base.film, **film), **given)


def main() -> int:
    """Render."""
    chosen = options()
    session = session_of(chosen)
    photograph(session, chosen.folder, partial(print, flush=True))
    if "sheet" in chosen:
        sheet(session, Path(chosen.folder), Path(chosen.sheet))
    return 0


def sheet(session: Session, folder: Path, picture: Path) -> None:
    """The photographs of the first and of the last pose, small: a row a ring of cameras."""
    rows = []
    columns = -(-session.count // len(session.rings))
    for pose in dict.fromkeys([session.names[0], session.names[-1]]):
        files = sorted((folder / pose).glob("*.jpg"))
        small = [
            cv2.resize(cv2.imread(str(file)), SHOWN, interpolation=cv2.INTER_AREA) for file in files
        ]
        for ring in np.array_split(np.arange(session.count), len(session.rings)):
            row = [small[shot] for shot in ring]
            rows.append(np.hstack(row + [np.zeros_like(row[0])] * (columns - len(row))))
    cv2.imwrite(str(picture), np.vstack(rows))


if __name__ == "__main__":
    sys.exit(main())
