"""The tests of numerical code as other processors round: what `make processors` runs.

    python tools/processors.py -n auto

A product of matrices is computed by those routines of OpenBLAS that suit the processor, a power or
an exponential by those of NumPy. Each of them rounds in its own way, and each can be asked for on
any processor that has its instructions. Words are handed to pytest; the exit status is not 0 where
a test fails.
"""

from __future__ import annotations

import json
import os
import platform
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]
# Where results are sums and products, and where they are written and read back.
FOLDERS = (
    *("character", "curves", "evaluation", "fitting", "io", "model", "paths", "physics", "rig"),
    *("samples", "tools"),
)
# Routines of OpenBLAS, and the feature of the processor without which they cannot run.
CORES = {"Prescott": "SSE3", "Haswell": "AVX2", "Zen": "AVX2", "SkylakeX": "AVX512F"}

ASK = """
import json, numpy, scipy.linalg, threadpoolctl
from numpy._core import _multiarray_umath as core
print(json.dumps({
    "has": [name for name, there in core.__cpu_features__.items() if there],
    "chosen": [name for name in core.__cpu_dispatch__ if core.__cpu_features__[name]],
    "cores": sorted({each["architecture"] for each in threadpoolctl.threadpool_info()
                     if each["internal_api"] == "openblas"}),
}))
"""


def found(**variables: str) -> dict[str, list[str]]:
    """What NumPy and OpenBLAS choose with some variables of the environment."""
    done = subprocess.run(
        [sys.executable, "-c", ASK], env=os.environ | variables, capture_output=True, check=True
    )
    answer: dict[str, list[str]] = json.loads(done.stdout)
    return answer


def settings() -> list[dict[str, str]]:
    """Variables of the environment, one set for each kind of processor that can be had here."""
    here, kinds, seen = found(), [], []
    for core, needs in CORES.items():
        # A build of OpenBLAS that lacks some routines takes others in their place.
        cores = found(OPENBLAS_CORETYPE=core)["cores"] if needs in here["has"] else []
        if cores and cores not in seen:
            kinds.append({"OPENBLAS_CORETYPE": core})
            seen.append(cores)
    wide = [name for name in here["chosen"] if "512" in name or name == "X86_V4"]
    for without in (wide, here["chosen"]):
        variables = {"NPY_DISABLE_CPU_FEATURES": " ".join(without)}
        if without and variables not in kinds:
            kinds.append(variables)
    return kinds


def main() -> int:
    """Run the tests once for each kind of processor, and say what came out."""
    if platform.machine() not in ("x86_64", "AMD64"):
        print(f"no other kinds of a processor of {platform.machine()} are known")
        return 0
    results = []
    for variables in settings():
        words = " ".join(f"{name}='{value}'" for name, value in variables.items())
        chosen = found(**variables)
        print(f"\n{words}: OpenBLAS {', '.join(chosen['cores'])}; NumPy {chosen['chosen']}")
        done = subprocess.run(
            [sys.executable, "-m", "pytest", *(f"tests/{each}" for each in FOLDERS), *sys.argv[1:]],
            cwd=ROOT,
            env=os.environ | variables,
            check=False,
        )
        results.append((done.returncode, words))
    print()
    for status, words in results:
        print(f"{'failed' if status else 'passed'}: {words}")
    return int(any(status for status, _ in results))


if __name__ == "__main__":
    sys.exit(main())
