"""`python -m pelagos` is the command `pelagos`."""

import os
import sys

if sys.path and sys.path[0] in ("", os.getcwd()):
    del sys.path[0]  # where a stranger's scenario lies, a module of any name may lie beside it

from pelagos.cli.main import main

main()
