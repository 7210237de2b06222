"""Commands killed at random moments: the old file or the complete new one, never half of one.

    python benchmarks/kills.py --times 50

Each command first runs undisturbed. Then it is started again and again over an older file and
killed, without a chance to clean up, at a moment drawn from its whole run, more often towards the
end, where it writes. What lies there afterwards must be one of the two files, byte by byte, and the
next run must leave nothing of the killed ones behind.
"""

from __future__ import annotations

import argparse
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory

__all__ = ["COMMANDS", "Killed", "kill_again_and_again"]

_ONLY = ("--only", "jawOpen,mouthFunnel")
COMMANDS: dict[str, tuple[str, ...]] = {
    "export head.glb": ("export", "rig.glb", *_ONLY, "-o", "head.glb"),
    "export head.npz": ("export", "rig.glb", *_ONLY, "-o", "head.npz"),
    "export head.usdc": ("export", "rig.glb", *_ONLY, "-o", "head.usdc"),
    "curves": ("curves", "neutral.obj", "-o", "curves.json"),
    "interpolate frames": (
        *("interpolate", "neutral.obj", "funnel.obj", "--frames", "40", "-o", "half.####.obj"),
    ),
}
"""What is killed, by a name for the table; the files it writes lie in the folder it runs in."""


@dataclass
class Killed:
    """What was found after the kills of one command.

    Attributes:
        old: Kills after which the older files lay there.
        new: Kills after which the complete new files lay there; of several files of one command
            some may be new and some old.
        broken: Names of files that were neither.
        orphans: Temporary files that kills left.
        after: Temporary files that the next run left.
    """

    old: int = 0
    new: int = 0
    broken: list[str] = field(default_factory=list)
    orphans: int = 0
    after: int = 0

    @property
    def whole(self) -> int:
        """Kills that left nothing but whole files."""
        return self.old + self.new


def kill_again_and_again(command: tuple[str, ...], times: int, chance: random.Random) -> Killed:
    """Kill a command at random moments and look at its files.

    Args:
        command: Words after ``elastomorph``.
        times: How often.
        chance: Draws the moments.
    """
    found = Killed()
    with TemporaryDirectory() as place:
        folder, temporary = Path(place) / "work", Path(place) / "temporary"
        folder.mkdir()
        temporary.mkdir()
        _write_inputs(folder)
        inputs = set(folder.iterdir())
        start = time.perf_counter()
        _complete(command, folder, temporary)
        seconds = time.perf_counter() - start
        new = {path: path.read_bytes() for path in set(folder.iterdir()) - inputs}
        if not new:
            raise SystemExit(f"elastomorph {' '.join(command)} wrote nothing")
        old = dict.fromkeys(new, b"an older file\n")
        for _ in range(times):
            for path, content in old.items():
                path.write_bytes(content)
            with _running(command, folder, temporary):
                time.sleep(seconds * (1.05 - 0.9 * chance.random() ** 2))
            now = {path: path.read_bytes() for path in new}
            broken = [p.name for p in new if now[p] not in (old[p], new[p])]
            found.broken += broken
            if not broken:
                found.old += now == old
                found.new += now != old
            found.orphans += len(_others(folder, inputs | set(new)) + _others(temporary, set()))
        if _complete(command, folder, temporary):
            raise SystemExit(f"elastomorph {' '.join(command)} failed after it was killed")
        found.after = len(_others(folder, inputs | set(new)) + _others(temporary, set()))
    return found


def _write_inputs(folder: Path) -> None:
    import elastomorph as em

    sys.path.append(str(Path(__file__).parents[1] / "tests"))
    from small_head import head, rig_file, shapes

    shutil.copy(rig_file(), folder / "rig.glb")
    em.write(folder / "neutral.obj", head())
    em.write(folder / "funnel.obj", shapes()["mouthFunnel"])


def _complete(command: tuple[str, ...], folder: Path, temporary: Path) -> int:
    """The exit status of a run that nobody disturbs."""
    with _running(command, folder, temporary) as process:
        return process.wait()


@contextmanager
def _running(
    command: tuple[str, ...], folder: Path, temporary: Path
) -> Iterator[subprocess.Popen[bytes]]:
    """A command that is killed at the end, with all that it started."""
    process = subprocess.Popen(
        [sys.executable, "-m", "elastomorph", *command],
        cwd=folder,
        env=os.environ | {"TMPDIR": str(temporary)},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )
    with process:
        try:
            yield process
        finally:
            with suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)


def _others(folder: Path, known: set[Path]) -> list[Path]:
    return [path for path in folder.iterdir() if path not in known]


def main() -> None:
    """Print the table; exit status 1 where anything was broken or left behind."""
    words = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    words.add_argument("--times", type=int, default=50, help="kills in all")
    words.add_argument("--seed", type=int, default=0)
    given = words.parse_args()
    chance = random.Random(given.seed)
    shares = [given.times // len(COMMANDS)] * len(COMMANDS)
    shares[0] += given.times - sum(shares)
    print(f"{'command':<20}{'kills':>6}{'old':>6}{'new':>6}{'broken':>8}{'orphans':>9}{'after':>7}")
    whole = bad = 0
    for (name, command), times in zip(COMMANDS.items(), shares, strict=True):
        found = kill_again_and_again(command, times, chance)
        whole += found.whole
        bad += len(found.broken) + found.after
        counts = f"{len(found.broken):>8}{found.orphans:>9}{found.after:>7}"
        print(f"{name:<20}{times:>6}{found.old:>6}{found.new:>6}{counts}", flush=True)
    print(f"{whole} of {given.times} whole")
    sys.exit(bool(bad))


if __name__ == "__main__":
    main()
