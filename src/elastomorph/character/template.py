"""A settings file written from what a folder holds, for people to go on from.

Prose stands behind ``# ``. Lines that begin with ``#`` and no space are settings to switch on:
without the ``#`` they are valid, one by one and all together.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable
from pathlib import Path
from textwrap import wrap

from elastomorph.character.read import FILE_NAME
from elastomorph.character.suggestions import (
    arkit_names,
    correctives,
    missing_arkit,
    slider_groups,
    turning,
)
from elastomorph.character.survey import Survey, survey
from elastomorph.errors import FileError
from elastomorph.io.atomic import replacing

__all__ = ["settings_text", "write_settings"]

_WIDTH = 88
_MOST_NAMES = 60


def write_settings(
    folder: str | Path,
    *,
    neutral: str | None = None,
    force: bool = False,
    say: Callable[[str], None] = lambda _: None,
) -> tuple[Path, Survey]:
    """Write the settings file of a folder, whole or not at all.

    Args:
        folder: The folder of a character.
        neutral: Name of the file of the neutral, where its name does not tell.
        force: Replace a settings file that is there.
        say: Told what is being done.

    Returns:
        The file, and what was found.

    Raises:
        FileError: There is a settings file already, or nothing of a character; or the file cannot
            be written.
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
    lines = [
        f"# Settings of {_plain(_title(found))}, as 'elastomorph init' found them.",
        "# Lines that begin with # and no space are suggestions: delete the # to use one.",
        "# Names of files are relative to this file. All keys: docs/settings.md",
        "",
        *_character(found),
        *_method(found),
        *_methods([name for name in turning(plain) if name not in found.inbetweens]),
        *_regions(found),
        *_inbetweens(found),
        *_correctives(corrected),
        *_groups(slider_groups(ends)),
        *_rest(),
    ]
    return "\n".join(lines) + "\n"


def _character(found: Survey) -> list[str]:
    lines = ["[character]", f"name = {_text(_title(found))}"]
    lines.append('#unit = "cm"                  # mm, cm, m or in: USD files state it')
    if found.rig is not None:
        lines += [f"rig = {_text(found.rig.name)}", *_prose(_what_shapes(found, "sliders"))]
    else:
        neutral = [] if found.neutral is None else [found.neutral]
        lines += [
            *(f"neutral = {_text(_relative(found, file))}" for file in neutral),
            f"targets = {_targets(found)}",
            *_prose(_what_shapes(found, "targets")),
        ]
    lines += _prose(*_arkit(found))
    if found.curves:
        lines.append(f"curves = {_text(found.curves[0].name)}")
        for file in found.curves[1:]:
            lines += _prose(f"{_plain(file.name)} has curves for this neutral too.")
    for name, count in found.sequences.items():
        lines += _prose(
            f"Motion, not used for the rig: {_plain(name)}, {count} frames. "
            "Compare methods with it: elastomorph evaluate"
        )
    for file in found.takes:
        lines += _prose(f"A performance: {_plain(file.name)}. Play it: elastomorph animate")
    for file in found.other_rigs:
        lines += _prose(f"Another rig, not used: {_plain(file.name)}")
    return [*lines, ""]


def _what_shapes(found: Survey, what: str) -> str:
    names = ", ".join(found.shapes[:_MOST_NAMES]) + (
        ", …" if len(found.shapes) > _MOST_NAMES else ""
    )
    return f"{len(found.shapes)} {what} of {found.vertices:,} vertices: {_plain(names)}"


def _arkit(found: Survey) -> list[str]:
    known, missing = arkit_names(found.shapes), missing_arkit(found.shapes)
    if not known:
        return ["None of them has a name of ARKit's shapes."]
    lines = [f"{len(known)} have names of ARKit's 52 shapes, which recorded performances drive."]
    if missing:
        lines.append(f"Missing of ARKit's: {', '.join(missing)}")
    return lines


def _method(found: Survey) -> list[str]:
    default = 'default = "auto"'
    lines = ["[method]"]
    if found.rig is None:
        lines += [
            *_prose(
                "Of every target that no other line names: straight where a turn would hardly "
                "differ from it, else turned."
            ),
            default,
        ]
    else:
        lines += [
            *_prose("Paths that the rig has of its own stay; this makes new ones for all."),
            "#" + default,
        ]
    return [
        *lines,
        "#straight_within = 5e-4       # so close, of D, that a straight line will do",
        "#tolerance = 1e-4             # how closely bends hold their path, of D",
        *_prose(
            'The paper\'s methods change the timing too, as default = "beam:2" does. Their '
            "closure, material and stiffness: docs/settings.md"
        ),
        "",
    ]


def _methods(names: list[str]) -> list[str]:
    lines = ["[methods]"]
    if names:
        lines += _prose(
            "By their names these turn: on a straight path a jaw shrinks and a lid cuts through "
            "the eye. 'auto' measures that; 'rotation' turns them however little it is."
        )
    else:
        lines += _prose('A target or a pattern and its method, such as "eyeBlink_*" = "rotation".')
    return [*lines, *(f'#{_key(name)} = "rotation"' for name in names), ""]


def _regions(found: Survey) -> list[str]:
    lines = _prose("Parts of the face with a method or material of their own.")
    if not found.regions:
        lines += _prose('[regions.mouth] needs vertices = "mouth.json" and a method or material.')
    for file in found.regions:
        lines += [
            f"#[regions.{_key(file.stem)}]",
            f"#vertices = {_text(file.name)}",
            "#falloff = 3                  # rings of edges over which it blends into the rest",
            '#method = "rotation"',
        ]
    return [*lines, ""]


def _inbetweens(found: Survey) -> list[str]:
    if not found.inbetweens:
        return []
    lines = _prose(
        "By their names these are shapes on the way to a target. Its path then passes through "
        "them, and they are no targets of their own."
    )
    for name, shapes in found.inbetweens.items():
        lines.append(f"#[inbetweens.{_key(name)}]")
        lines += [f'#"{t:g}" = {_text(_relative(found, file))}' for t, file in shapes.items()]
    return [*lines, ""]


def _correctives(drivers: dict[str, list[str]]) -> list[str]:
    lines = ["[correctives]"]
    if drivers:
        lines += _prose(
            "By their names these correct others: their weight is the product of those named. "
            "Switch one on where the shape was made on top of them."
        )
    else:
        lines += _prose("A corrective and the sliders whose weights, multiplied, drive it.")
    return [*lines, *(f"#{_key(name)} = {_list(own)}" for name, own in drivers.items()), ""]


def _groups(groups: dict[str, list[str]]) -> list[str]:
    lines = ["[groups]", *_prose("Names or patterns of sliders, for programs that show groups.")]
    return [*lines, *(f"#{_key(name)} = {_list(own)}" for name, own in groups.items()), ""]


def _rest() -> list[str]:
    return [
        "[timing]",
        *_prose("How t runs over exported clips; never part of the path."),
        '#default = "minimum-jerk"',
        "",
        "[export.glb]",
        '#normals = "none"             # about half the size',
        "#tolerance = 5e-7             # bends that move less, of D, are left out",
        "#fps = 30",
        "",
        "[export.usd]",
        "#most_inbetweens = 3",
    ]


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
        shown = [_relative(found, folder / f"*{suffix}") for folder, suffix in patterns]
    else:
        shown = [_relative(found, file) for file in found.targets.values()]
    if len(shown) == 1:
        return _text(shown[0])
    lines = wrap(", ".join(_text(name) for name in shown), _WIDTH, break_on_hyphens=False)
    # A name with a space must not be broken across two lines.
    whole = all(" " not in name for name in shown)
    return "\n".join(["[", *(f"  {line}" for line in lines), "]"]) if whole else _list(shown)


def _list(names: Iterable[str]) -> str:
    return f"[{', '.join(_text(name) for name in names)}]"


def _relative(found: Survey, file: Path) -> str:
    return file.relative_to(found.folder).as_posix()


def _title(found: Survey) -> str:
    return found.folder.name or found.folder.resolve().name or "face"


def _text(value: str) -> str:
    """A TOML string.

    Raises:
        FileError: The name of a file is no Unicode text.
    """
    try:
        value.encode()
    except UnicodeEncodeError:
        raise FileError(
            value.encode("ascii", "backslashreplace").decode(),
            "the name of this file is no Unicode text, as a settings file needs; rename it",
        ) from None
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")


def _key(name: str) -> str:
    bare = name.replace("_", "").replace("-", "")
    return name if bare.isascii() and bare.isalnum() else _text(name)


def _plain(text: str) -> str:
    """Text for a comment, in which control characters are not allowed."""
    return "".join(c if c.isprintable() else "?" for c in text)


def _prose(*sentences: str) -> list[str]:
    return [f"# {line}" for text in sentences for line in wrap(text, _WIDTH)]
