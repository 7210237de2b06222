"""Scripts that processes started from them would run again.

A process that Python starts for workers runs the script of its parent once more, from its first
line, to know what that defined; only ``if __name__ == "__main__"`` is left out. A script that
starts workers elsewhere would start them without end.
"""

from __future__ import annotations

import ast
import sys
from pathlib import Path
from types import FrameType

from elastomorph.errors import ParameterError


def require_guarded_main() -> None:
    """Refuse a script that calls this, however indirectly, where each new process would again.

    Raises:
        ParameterError: The call is not below ``if __name__ == "__main__"``.
    """
    frame = _frame_of_main()
    if frame is None:
        return
    path, line = frame.f_code.co_filename, frame.f_lineno
    try:
        statements = ast.parse(Path(path).read_bytes()).body
    except (OSError, SyntaxError, ValueError):
        return  # typed in, or made by a program: there is no file that could be run again
    for statement in statements:
        if statement.lineno <= line <= (statement.end_lineno or line):
            asks = isinstance(statement, ast.If) and any(
                isinstance(node, ast.Name) and node.id == "__name__"
                for node in ast.walk(statement.test)
            )
            if not asks:
                raise ParameterError(
                    f'{path}, line {line}: put what stands here below  if __name__ == "__main__":  '
                    "for each process that is started runs this script again up to there"
                )


def _frame_of_main() -> FrameType | None:
    """The script's own frame among those that led here; None where there is no script."""
    main = sys.modules.get("__main__")
    frame: FrameType | None = sys._getframe()
    while frame is not None:
        if frame.f_globals is vars(main) and frame.f_code.co_name == "<module>":
            return frame
        frame = frame.f_back
    return None
