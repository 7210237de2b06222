"""How tests call the command line."""

from __future__ import annotations

from types import ModuleType

import pytest
import typer
from typer.testing import CliRunner

from elastomorph.cli import main


def status_of(*arguments: object) -> int:
    """The exit status of one call of the program."""
    with pytest.raises(SystemExit) as stopped:
        main([str(argument) for argument in arguments])
    code = stopped.value.code
    return code if isinstance(code, int) else 0


def printed_by(verb: ModuleType, *words: object, width: int = 100) -> str:
    """What one verb prints, on a terminal of that width."""
    app = typer.Typer()
    app.callback()(lambda: None)
    verb.add_to(app)
    result = CliRunner().invoke(
        app,
        [str(word) for word in words],
        env={"COLUMNS": str(width), "TERM": "dumb"},
        catch_exceptions=False,
    )
    assert result.exit_code == 0
    return result.stdout
