"""Readings that are computed when somebody looks at them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

from pelagos.sensors.sensor import Reading


class Later(Mapping[str, Mapping[str, Reading]]):
    """Readings by agent and sensor, as `Simulation.step` returns them, of which the first look computes all."""

    def __init__(self, look: Callable[[], Mapping[str, Mapping[str, Reading]]]) -> None:
        self._look: Callable[[], Mapping[str, Mapping[str, Reading]]] | None = look
        self._found: Mapping[str, Mapping[str, Reading]] = {}

    def _all(self) -> Mapping[str, Mapping[str, Reading]]:
        if self._look is not None:
            self._found, self._look = self._look(), None
        return self._found

    def __getitem__(self, agent: str) -> Mapping[str, Reading]:
        return self._all()[agent]

    def __iter__(self) -> Iterator[str]:
        return iter(self._all())

    def __len__(self) -> int:
        return len(self._all())

    def __repr__(self) -> str:
        return repr(self._all())

    def __reduce__(self) -> tuple[type[dict[str, Mapping[str, Reading]]], tuple[dict[str, Mapping[str, Reading]]]]:
        return dict, (dict(self._all()),)
