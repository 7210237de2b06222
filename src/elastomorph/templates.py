"""HTML from the templates of a package: every value is escaped, and a missing one is an error."""

from __future__ import annotations

import re
from functools import cache

from jinja2 import Environment, PackageLoader, StrictUndefined

# Control characters have no place in HTML, not even as references; lone halves of surrogate pairs
# cannot be written as UTF-8. Both come from file names.
_UNFIT = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\ud800-\udfff]")


def rendered(package: str, template: str, **context: object) -> str:
    """What a template of a package such as ``elastomorph.report`` makes of some values.

    It is in the folder ``templates``; what is not `markupsafe.Markup` is text.
    """
    page = _environment(package).get_template(template).render(context)
    return _UNFIT.sub("\ufffd", page.replace("\r", "\n"))


@cache
def _environment(package: str) -> Environment:
    return Environment(
        loader=PackageLoader(package),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
