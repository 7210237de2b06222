"""What stands above faces: by which method they were made, and whether at an even pace."""

from __future__ import annotations

from collections.abc import Iterable

from elastomorph.model.morph import Morph

__all__ = ["method_words"]


def method_words(morphs: Iterable[Morph]) -> str:
    """Such as "method auto, even timing" or "method beam R=2, uneven timing".

    Args:
        morphs: The paths shown.
    """
    paths = list(morphs)
    labels = dict.fromkeys("auto" if path.choice is not None else path.method for path in paths)
    even = all(not path.limit_law(0.25) for path in paths)
    names = ", ".join(labels)
    what = "method" if len(labels) == 1 else "methods"
    return f"{what} {names}, {'even' if even else 'uneven'} timing"
