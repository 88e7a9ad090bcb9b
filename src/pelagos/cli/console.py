"""Consoles of the command line: results to the standard output, progress and errors to the standard error."""

from __future__ import annotations

import os
import re
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, Final, TextIO

from rich.console import Console
from rich.panel import Panel
from rich.text import Text

from pelagos.errors import PelagosWarning

# C0 but tab and newline, delete, C1, line and paragraph separators, and marks that turn the direction of writing
_CONTROL: Final = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u2028-\u202e\u2066-\u2069\u200e\u200f]")


def visible(text: str) -> str:
    """A text whose control characters are written out: a name in a stranger's scenario moves no cursor."""
    return _CONTROL.sub(lambda found: found[0].encode("unicode_escape").decode("ascii"), text)


class _Console(Console):
    """A console on which no text controls the terminal; colours are Rich's own."""

    def render_str(self, text: str, *arguments: Any, **options: Any) -> Text:
        """See `rich.console.Console.render_str`."""
        return super().render_str(visible(text), *arguments, **options)


out = _Console(highlight=False, soft_wrap=True)
err = _Console(stderr=True, highlight=False)


@contextmanager
def doing(what: str) -> Iterator[None]:
    """Tell what takes a while: by a spinner on a terminal, elsewhere by one line at the beginning."""
    if err.is_terminal:
        with err.status(Text(visible(what))):
            yield
    else:
        err.print(f"{what} ...", markup=False, soft_wrap=True)
        yield


def show_error(title: str, message: str) -> None:
    """One error: a box on a terminal, a single plain block of text elsewhere."""
    message = visible(message)
    if err.is_terminal:
        err.print(Panel(Text(message), title=title, title_align="left", border_style="red", expand=False))
    else:
        sys.stderr.write(f"{title}: {message}\n")


def show_warning(
    message: Warning | str, category: type[Warning], filename: str, lineno: int, file: TextIO | None = None,
    line: str | None = None,
) -> None:  # fmt: skip
    """In place of `warnings.showwarning`: what the program warns of, without the line of it that does."""
    message = visible(str(message))
    if not issubclass(category, PelagosWarning):
        sys.stderr.write(warnings.formatwarning(message, category, filename, lineno, line))
    elif err.is_terminal:
        err.print(Text.assemble(("warning: ", "yellow"), str(message)))
    else:
        sys.stderr.write(f"warning: {message}\n")


def shown(path: os.PathLike[str] | str) -> str:
    """A path as short as it can be said: relative where it lies under the working folder."""
    absolute = os.path.abspath(path)
    relative = os.path.relpath(absolute)
    return absolute if relative.startswith("..") else relative
