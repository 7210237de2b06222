"""What three.js, Babylon.js and Blender show of bent characters: a row a file and program.

Run:  python benchmarks/players.py FILE… [--synthetic NAME…]

Each file is bent into a temporary folder. The original and the bent file are then shown in each
program, skinned, by sliders (0, 1, between, mixed) and by every clip, at its keys and between; what
it shows is compared with the formulas of the specification, written in NumPy, with the original,
and with the path of ``auto``. Distances are the largest found, as fractions of D. Packed files are
decoded first. Needs Node.js with the packages of ``web``; Blender is the Python
with ``bpy`` that the variable ELASTOMORPH_BLENDER_PYTHON names, or that of ``make test-blender``.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from pathlib import Path

import elastomorph as em
from acceptance.judging import Pair
from acceptance.players import PLAYERS, command
from acceptance.playing import Played, play
from acceptance.tools import synthetic

_HEAD = (
    "| file | program | poses | moments | specified (original) | at 0 and 1 "
    "| auto between (straight) | at keys | between keys | seconds | |\n|" + " --- |" * 11
)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("files", nargs="*", type=Path)
    parser.add_argument("--synthetic", nargs="+", default=[], help="of those that the tests make")
    options = parser.parse_args()
    players = [player for player in PLAYERS if command(player)]
    for player in set(PLAYERS) - set(players):
        print(f"{player} is not installed.")
    print(_HEAD)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for file in [*options.files, *synthetic(options.synthetic, folder)]:
            bent = folder / f"{file.stem}.bent{file.suffix}"
            em.bend(file, bent)
            pair = Pair(file, bent, folder)
            for player in players:
                start = time.perf_counter()
                found = play(pair, player, folder)
                print(_row(file.name, player, found, time.perf_counter() - start), flush=True)


def _row(file: str, player: str, found: Played, seconds: float) -> str:
    clips = [f"{own:.1e}" if found.moments else "" for own in (found.keys, found.clips)]
    said = f"does not play {', '.join(found.unplayed)} of the original" if found.unplayed else ""
    cells = [
        file,
        player,
        str(found.poses),
        str(found.moments),
        f"{found.posed:.1e} ({found.original:.1e})",
        f"{found.ends:.1e}",
        f"{found.between:.1e} ({found.straight:.1e})",
        *clips,
        f"{seconds:.0f}",
        said,
    ]
    return f"| {' | '.join(cells)} |"


if __name__ == "__main__":
    main()
