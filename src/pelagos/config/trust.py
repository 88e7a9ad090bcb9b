"""Trust: what a scenario may do to the machine that reads it.

A scenario is data. It becomes a program where it names a function of Python, "module:function": such names are refused
unless whoever loads the scenario says that it is trusted (`trust=True`, `--trust`). Components that an installed
package declares by an entry point are code that was installed on purpose, and need no trust.
"""

from __future__ import annotations

from typing import Annotated, TypeAlias

from pydantic import AfterValidator, ValidationInfo

from pelagos.config.strict import refusal


def _trusted(target: str, info: ValidationInfo) -> str:
    """A target as it is, where the validation's context trusts it, or where there is none: a program made it."""
    if ":" in target and isinstance(info.context, dict) and not info.context.get("trust", False):
        raise refusal(
            f"{target!r} is code that the scenario wants to run; if you trust whoever wrote the scenario, load it with "
            "trust=True, or with --trust on the command line"
        )
    return target


CodeTarget: TypeAlias = Annotated[str, AfterValidator(_trusted)]
"""The name of a function of Python, "module:function"."""
