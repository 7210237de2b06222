"""How tests call the command line."""

from __future__ import annotations

import pytest
from typer.testing import CliRunner

from elastomorph.cli import app, main


def status_of(*arguments: object) -> int:
    """The exit status of one call of the program."""
    with pytest.raises(SystemExit) as stopped:
        main([str(argument) for argument in arguments])
    code = stopped.value.code
    return code if isinstance(code, int) else 0


def printed_by(*words: object, width: int = 100) -> str:
    """What a call prints, on a terminal of that width."""
    result = CliRunner().invoke(
        app,
        [str(word) for word in words],
        env={"COLUMNS": str(width), "TERM": "dumb"},
        catch_exceptions=False,
    )
    assert result.exit_code == 0
    return result.stdout
