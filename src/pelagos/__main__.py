"""`python -m pelagos` is the command `pelagos`."""

from pelagos.cli.main import main

main()
