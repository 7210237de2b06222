"""Runs trials format by format, starts them again where one ends them, and adds up the outcomes."""

from __future__ import annotations

import json
import os
import select
import subprocess
import sys
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

__all__ = ["Row", "run"]

_SILENCE = 30.0
_HERE = Path(__file__).resolve().parents[1]


@dataclass
class Row:
    """What came of the inputs of one format."""

    name: str
    tried: int = 0
    loaded: int = 0
    refused: int = 0
    seconds: float = 0.0
    slowest: str = ""
    memory: int = 0
    largest: str = ""
    failures: list[tuple[int, str, str]] = field(default_factory=list)
    messages: dict[str, int] = field(default_factory=dict)

    def add(self, number: int, told: dict[str, Any]) -> None:
        """Count one input."""
        self.tried += 1
        self.loaded += told["outcome"] == "loaded"
        self.refused += told["outcome"] == "refused"
        if told["outcome"] == "failed":
            self.failures.append((number, told["label"], told["problem"]))
        if told["message"]:
            self.messages[told["message"]] = number
        if told["small"] and told["seconds"] > self.seconds:
            self.seconds, self.slowest = told["seconds"], f"{number}: {told['label']}"
        if told["small"] and told["memory"] > self.memory:
            self.memory, self.largest = told["memory"], f"{number}: {told['label']}"


class _Trial:
    """One process that reads inputs of a format, from a number on."""

    def __init__(self, name: str, seed: int, first: int, folder: Path) -> None:
        paths = [str(_HERE), *filter(None, [os.environ.get("PYTHONPATH")])]
        self._process = subprocess.Popen(
            [sys.executable, "-m", "hostile.trial", name, str(seed), str(first), str(folder)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            env={**os.environ, "PYTHONPATH": os.pathsep.join(paths)},
        )
        self._rest = b""
        self.number, self.label, self.by_hand = first, "starting", True

    def go_on(self, row: Row, seconds: float) -> bool:
        """Read inputs for some time; whether the process is still there at the end."""
        assert self._process.stdin is not None
        self._process.stdin.write(f"{seconds}\n".encode())
        self._process.stdin.flush()
        while True:
            line = self._line()
            if line is None:
                return False
            told = json.loads(line)
            if "paused" in told:
                self.number, self.by_hand = told["paused"], told["by_hand"]
                return True
            if "outcome" in told:
                row.add(self.number, told)
            else:
                self.number, self.label = told["number"], told["label"]

    def end(self) -> str:
        """End the process; how it ended if it did so itself."""
        ended = self._process.poll()
        if ended is None:
            self._process.kill()
        self._process.wait()
        for pipe in (self._process.stdin, self._process.stdout):
            if pipe:
                pipe.close()
        return f"the process ended with {ended}" if ended is not None else "no answer in 30 s"

    def _line(self) -> bytes | None:
        assert self._process.stdout is not None
        while b"\n" not in self._rest:
            if not select.select([self._process.stdout], [], [], _SILENCE)[0]:
                return None
            got = os.read(self._process.stdout.fileno(), 1 << 16)
            if not got:
                self._process.wait()
                return None
            self._rest += got
        line, _, self._rest = self._rest.partition(b"\n")
        return line


def run(name: str, seed: int, seconds: float, folder: Path) -> Row:
    """Try inputs of a format for some time, but at least those that chance has no part in.

    Args:
        name: The format.
        seed: Of chance.
        seconds: How long.
        folder: Where the inputs are written.
    """
    row = Row(name)
    stop = time.monotonic() + seconds
    trial = _Trial(name, seed, 0, folder)
    alive = True
    while not alive or time.monotonic() < stop or trial.by_hand:
        if not alive:
            row.tried += 1
            row.failures.append((trial.number, trial.label, trial.end()))
            if len(row.failures) > 200:
                break
            trial = _Trial(name, seed, trial.number + 1, folder)
        alive = trial.go_on(row, min(2.0, max(0.2, stop - time.monotonic())))
    trial.end()
    return row
