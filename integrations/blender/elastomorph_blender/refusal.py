"""What the extension refuses, in one sentence each."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from elastomorph import ElastomorphError


class RefusedError(ElastomorphError):
    """Something in the scene that cannot be bent, and what to do about it."""


@contextmanager
def reported(operator: object) -> Iterator[None]:
    """Errors of elastomorph as reports of an operator; its ``failed`` then says so."""
    operator.failed = False  # type: ignore[attr-defined]
    try:
        yield
    except ElastomorphError as error:
        operator.failed = True  # type: ignore[attr-defined]
        operator.report({"ERROR"}, str(error))  # type: ignore[attr-defined]
