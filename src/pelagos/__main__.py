"""`python -m pelagos` is the command `pelagos`."""

from __future__ import annotations

import os
import signal
import sys


def command() -> None:
    """Run the command line; Ctrl-C while its modules are imported ends the process without a traceback."""
    before = signal.getsignal(signal.SIGINT)
    if before is signal.default_int_handler:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    from pelagos.cli.main import main

    signal.signal(signal.SIGINT, before)
    main()


if __name__ == "__main__":
    if sys.path and sys.path[0] in ("", os.getcwd()):
        del sys.path[0]  # where a stranger's scenario lies, a module of any name may lie beside it
    command()
