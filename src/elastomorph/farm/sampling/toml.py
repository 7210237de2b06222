"""TOML as text, for recipes that are kept with their data."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any


def toml_text(content: Mapping[str, Any]) -> str:
    """Tables and lists of tables of plain values; numbers are read back as the same numbers."""
    lines = [_line(*item) for item in content.items() if not _is_table(item[1])]
    for name, value in content.items():
        for table in [value] if isinstance(value, Mapping) else value if _is_table(value) else []:
            header = f"[{_key(name)}]"
            lines += ["", header if isinstance(value, Mapping) else f"[{header}]"]
            lines += [_line(*item) for item in table.items()]
    return "\n".join(lines) + "\n"


def _is_table(value: Any) -> bool:
    several = isinstance(value, list | tuple) and len(value) > 0 and isinstance(value[0], Mapping)
    return several or isinstance(value, Mapping)


def _line(name: str, value: Any) -> str:
    return f"{_key(name)} = {_value(value)}"


def _key(name: str) -> str:
    bare = name.isascii() and name.replace("-", "_").isidentifier()
    return name if bare else _value(name)


def _value(value: Any) -> str:
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_value, value))}]"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        # JSON says all that TOML does, but for one sign.
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    return repr(value)
