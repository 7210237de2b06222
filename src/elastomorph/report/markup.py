"""HTML from Python in which every text is escaped unless it is known to be markup."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

__all__ = ["Markup", "element", "escaped", "joined"]

_VOID = frozenset({"br", "hr", "img", "link", "meta", "col"})
_ESCAPES = str.maketrans({"&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;", "'": "&#39;"})
# Control characters have no place in HTML, not even as references; lone halves of surrogate pairs
# cannot be written as UTF-8. Both come from file names.
_CONTROLS = dict.fromkeys((*range(0x20), *range(0x7F, 0xA0), *range(0xD800, 0xE000)), "\ufffd")
for _kept in "\t\n":
    del _CONTROLS[ord(_kept)]
_CONTROLS[ord("\r")] = "\n"


class Markup(str):
    """Text that is HTML already."""

    __slots__ = ()


def escaped(text: object) -> Markup:
    """Anything as HTML text that reads the same; markup stays as it is."""
    if isinstance(text, Markup):
        return text
    return Markup(str(text).translate(_CONTROLS).translate(_ESCAPES))


def joined(children: Iterable[object]) -> Markup:
    """Texts and markup one after the other."""
    return Markup("".join(escaped(child) for child in children))


def element(
    tag: str, *children: object, attributes: Mapping[str, object] | None = None, **more: object
) -> Markup:
    """An element; its children and the values of its attributes are escaped unless `Markup`.

    Args:
        tag: Such as ``td``.
        *children: Texts, numbers and markup.
        attributes: Attributes by name. True stands for one without a value, None and False for
            none at all.
        **more: The same; ``class_`` is class, ``aria_label`` is aria-label.
    """
    pairs = dict(attributes or {})
    pairs.update((name.rstrip("_").replace("_", "-"), value) for name, value in more.items())
    words = [tag]
    for name, value in pairs.items():
        if value is True:
            words.append(name)
        elif value is not None and value is not False:
            # A quotation mark would end the value even of markup.
            words.append(f'{name}="{escaped(value).replace(chr(34), "&quot;")}"')
    opening = Markup(f"<{' '.join(words)}>")
    if tag in _VOID:
        return opening
    return Markup(f"{opening}{joined(children)}</{tag}>")
