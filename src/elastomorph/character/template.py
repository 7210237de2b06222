"""A settings file written from what a folder holds and its names suggest, to go on from.

In the file, prose stands behind ``# ``. Lines that begin with ``#`` and no space are settings to
switch on: without the ``#`` they are valid, one by one and all together.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from textwrap import wrap

import tomlkit
from jinja2 import Environment, PackageLoader, StrictUndefined

from elastomorph.character.read import FILE_NAME
from elastomorph.character.survey import Survey, survey
from elastomorph.errors import FileError
from elastomorph.io.atomic import replacing
from elastomorph.rig.performance.naming import ARKIT, shape_of, wholes

_WIDTH = 88
_MOST_NAMES = 60
_TURNING = re.compile(r"jawOpen|eyeBlink|eyeLook|blink|look")
_TURNING_WORDS = re.compile(
    r"jaw[._ -]?(open|drop|down)|mouth[._ -]?open|blink|lid[._ -]?clos", re.I
)
_PARTS = ("brow", "eye", "cheek", "nose", "jaw", "mouth", "tongue")


def write_settings(
    folder: str | Path,
    *,
    neutral: str | None = None,
    force: bool = False,
    say: Callable[[str], None] = lambda _: None,
) -> tuple[Path, Survey]:
    """Write the settings file of a folder, whole or not at all; the file, and what was found.

    ``neutral`` is the name of its file, where that does not tell; ``force`` replaces settings that
    are there.
    """
    file = Path(folder) / FILE_NAME
    if file.exists() and not force:
        raise FileError(file, "there are settings already; --force replaces them")
    found = survey(folder, neutral, say)
    text = settings_text(found)
    with replacing(file) as page:
        page.write(text.encode())
    return file, found


def settings_text(found: Survey) -> str:
    """The settings file for what was found in a folder."""
    between = {path.stem for own in found.inbetweens.values() for path in own.values()}
    ends = [name for name in found.shapes if name not in between]
    corrected = correctives(found.shapes)
    plain = [name for name in ends if name not in corrected]
    page = Environment(
        loader=PackageLoader("elastomorph.character"),
        undefined=StrictUndefined,
        trim_blocks=True,
        keep_trailing_newline=True,
    )
    page.filters |= {
        "key": _key,
        "list_of": _list,
        "plain": _plain,
        "prose": lambda text: "".join(f"# {line}\n" for line in wrap(text, _WIDTH)),
        "relative": lambda file: file.relative_to(found.folder).as_posix(),
        "text": _text,
    }
    more = ["…"] if len(found.shapes) > _MOST_NAMES else []
    return page.get_template(FILE_NAME).render(
        found=found,
        title=found.folder.name or found.folder.resolve().name or "face",
        targets=None if found.rig else _targets(found),
        shapes=", ".join([*found.shapes[:_MOST_NAMES], *more]),
        arkit=arkit_names(found.shapes),
        missing=missing_arkit(found.shapes),
        turning=[name for name in turning(plain) if name not in found.inbetweens],
        correctives=corrected,
        groups=slider_groups(ends),
    )


def _targets(found: Survey) -> str:
    """Patterns where they say exactly which files are meant, otherwise every file."""
    files = set(found.targets.values())
    patterns = sorted({(file.parent, file.suffix) for file in files})
    caught: set[Path] = set()
    for folder, suffix in patterns:
        caught |= {
            file
            for file in folder.iterdir()
            if file.suffix == suffix and not file.name.startswith(".") and file.is_file()
        }
    plain = all(letter not in str(folder.name) for folder, _ in patterns for letter in "*?[")
    if caught - {found.neutral} == files and plain:
        named = [folder / f"*{suffix}" for folder, suffix in patterns]
    else:
        named = list(found.targets.values())
    shown = [file.relative_to(found.folder).as_posix() for file in named]
    if len(shown) == 1:
        return _text(shown[0])
    lines = wrap(", ".join(_text(name) for name in shown), _WIDTH, break_on_hyphens=False)
    # A name with a space must not be broken across two lines.
    whole = all(" " not in name for name in shown)
    return "\n".join(["[", *(f"  {line}" for line in lines), "]"]) if whole else _list(shown)


def _list(names: Iterable[str]) -> str:
    return f"[{', '.join(_text(name) for name in names)}]"


def _text(value: str) -> str:
    """A TOML string."""
    return tomlkit.string(_unicode(value)).as_string()


def _key(name: str) -> str:
    return tomlkit.key(_unicode(name)).as_string()


def _unicode(value: str) -> str:
    try:
        value.encode()
    except UnicodeEncodeError:
        raise FileError(
            value.encode("ascii", "backslashreplace").decode(),
            "the name of this file is no Unicode text, as a settings file needs; rename it",
        ) from None
    return value


def _plain(text: str) -> str:
    """Text for a comment, in which control characters are not allowed."""
    return "".join(c if c.isprintable() else "?" for c in text)


def arkit_names(names: Sequence[str]) -> dict[str, str]:
    """The names that stand for one of ARKit's 52 shapes, and which."""
    found = {name: shape_of(name) for name in names}
    return {name: shape for name, shape in found.items() if shape in ARKIT}


def missing_arkit(names: Sequence[str]) -> list[str]:
    """The shapes of ARKit that no name stands for, nor two halves, in ARKit's order."""
    known = {shape_of(name) for name in names}
    known |= {whole.name for whole in wholes() if known.issuperset(whole.parts)}
    return [shape for shape in ARKIT if shape not in known]


def turning(names: Sequence[str]) -> list[str]:
    """Targets that turn by their names: jaws that open, lids that close, eyes that look."""
    return [
        name
        for name in names
        if _TURNING.match(shape_of(name) or "") or _TURNING_WORDS.search(name)
    ]


def correctives(names: Sequence[str]) -> dict[str, list[str]]:
    """Shapes that by their names belong on top of others, and what drives them.

    ARKit's mouthClose closes the lips of an open jaw; a name of other names, such as
    ``jawOpen_mouthFunnel``, corrects their sum.
    """
    by_shape = {shape: name for name, shape in arkit_names(names).items()}
    found: dict[str, list[str]] = {}
    if "mouthClose" in by_shape and "jawOpen" in by_shape:
        found[by_shape["mouthClose"]] = [by_shape["jawOpen"], by_shape["mouthClose"]]
    for name in names:
        parts = _joined(name, set(names) - {name})
        if parts:
            found[name] = parts
    return {
        name: drivers
        for name, drivers in found.items()
        if not any(own in found for own in drivers if own != name)
    }


def slider_groups(names: Sequence[str]) -> dict[str, list[str]]:
    """Sliders of one part of the face, or a pattern for just these, where there are two or more."""
    shapes = {name: shape_of(name) or name for name in names}
    found: dict[str, list[str]] = {}
    for part in _PARTS:
        own = [name for name, shape in shapes.items() if shape.startswith(part)]
        begin = own[0][: len(part)] if own else part
        if len(own) > 1:
            pattern = own == [name for name in names if name.startswith(begin)]
            found[part] = [f"{begin}*"] if pattern else own
    return found


def _joined(name: str, others: set[str]) -> list[str]:
    """The names that underscores join into this one; empty where it is not such."""
    words = name.split("_")
    parts: list[str] = []
    start = 0
    while start < len(words):
        # The longest first, so that mouthSmile_L is one name.
        for stop in range(len(words), start, -1):
            part = "_".join(words[start:stop])
            if part in others:
                parts.append(part)
                start = stop
                break
        else:
            return []
    return parts if len(parts) > 1 and len(set(parts)) == len(parts) else []
