"""One mistake that a test must notice, and the lists of them."""

from __future__ import annotations

import hashlib
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SOURCES = ROOT / "src" / "pelagos"
LISTS = Path(__file__).parent / "lists"
BETWEEN = ("\n\n", "\n\n\n")  # methods; functions and classes of a module, as the formatter has it


class BadMutant(ValueError):
    """An entry of a list that does not fit the source: its text is not there once, or changes nothing."""


@dataclass(frozen=True)
class Mutant:
    """A text of one source file, what replaces it, and the tests that are likely to see it."""

    layer: str
    """The list it stands in."""

    file: str
    """Path below `src/pelagos`."""

    text: str
    """What stands there; exactly once in the file."""

    mutation: str
    """What replaces it."""

    tests: tuple[str, ...]
    """Files or node ids for pytest, in the order to try them."""

    @property
    def package(self) -> str:
        """The part of Pelagos that it is in: `acoustics`, `vehicles`, ..."""
        return self.file.split("/")[0].removesuffix(".py")

    @property
    def key(self) -> str:
        """A name that survives changes elsewhere in the list."""
        return hashlib.sha256(f"{self.file}\0{self.text}\0{self.mutation}".encode()).hexdigest()[:10]

    def mutated(self) -> str:
        """The whole source with the mistake in it; raises `BadMutant`."""
        source = (SOURCES / self.file).read_text()
        count = source.count(self.text)
        if count != 1:
            raise BadMutant(f"{self.layer}: {self.file}: {self.text!r} stands there {count} times, not once")
        if self.text == self.mutation:
            raise BadMutant(f"{self.layer}: {self.file}: {self.text!r} is replaced by itself")
        for between in BETWEEN:
            try:
                compile(self._around(source, between), self.file, "exec")
            except SyntaxError:
                continue
            return source.replace(self.text, self.mutation)
        changed = source.replace(self.text, self.mutation)
        compile(changed, self.file, "exec")
        return changed

    def _around(self, source: str, between: str) -> str:
        """The mutated definition alone, which compiles in a tenth of the time of its module."""
        place = source.index(self.text)
        after = place + len(self.text)
        begin, end = source.rfind(between, 0, place) + 1, source.find(between, after) % len(source)
        definition = source[begin:place].lstrip("\n") + self.mutation + source[after:end]
        return f"class _:\n{definition}" if definition.startswith(" ") else definition


def read_mutants(layers: tuple[str, ...] = ()) -> Iterator[Mutant]:
    """All mutants of `lists/*.toml`, or of those lists that are named.

    A list is TOML: an array `module` of tables with `file`, `tests`, and `mutants`, pairs of text and replacement; a
    third member of a pair names tests of its own.
    """
    for path in sorted(LISTS.glob("*.toml")):
        if not layers or path.stem in layers:
            yield from read_list(path)


def read_list(path: Path) -> Iterator[Mutant]:
    """All mutants of one list; a module of somebody else's may have a `layer` of its own and no `tests`."""
    for module in tomllib.loads(path.read_text())["module"]:
        for text, mutation, *own in module["mutants"]:
            tests = tuple(own) or tuple(module.get("tests", ()))
            yield Mutant(module.get("layer", path.stem), module["file"], text, mutation, tests)
