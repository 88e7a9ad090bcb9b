"""What the command line prints to: results to the standard output, progress and errors to the standard error."""

from __future__ import annotations

import os
import sys
import warnings
from typing import TextIO

from rich.console import Console
from rich.panel import Panel
from rich.text import Text

from pelagos.errors import PelagosWarning

out = Console(highlight=False, soft_wrap=True)
err = Console(stderr=True, highlight=False)


def show_error(title: str, message: str) -> None:
    """One error: a box on a terminal, a single plain block of text elsewhere."""
    if err.is_terminal:
        err.print(Panel(Text(message), title=title, title_align="left", border_style="red", expand=False))
    else:
        sys.stderr.write(f"{title}: {message}\n")


def show_warning(
    message: Warning | str, category: type[Warning], filename: str, lineno: int, file: TextIO | None = None,
    line: str | None = None,
) -> None:  # fmt: skip
    """In place of `warnings.showwarning`: what the program warns of, without the line of it that does."""
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
