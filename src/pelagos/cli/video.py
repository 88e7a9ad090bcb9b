"""`pelagos video`: a film of a recording."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

from pelagos.cli.console import err, out, shown
from pelagos.cli.view import must_be_file
from pelagos.errors import InputError


@dataclass(frozen=True)
class VideoOptions:
    """Options of the command line; see `pelagos video --help`."""

    chase: bool = False
    camera: str | None = None
    sonar: str | None = None
    panels: bool = False
    speed: float = 1.0
    rate_hz: int = 20


def video(recording: Path, target: Path, options: VideoOptions) -> None:
    """Make it.

    Raises:
        InputError: more than one kind of film, or what `make_film` refuses.
    """
    kinds = {"chase": options.chase, "camera": options.camera, "sonar": options.sonar, "panels": options.panels}
    asked = [name for name, value in kinds.items() if value not in (None, False)]
    if len(asked) > 1:
        raise InputError(f"one kind of film at a time, not {' and '.join(f'--{name}' for name in asked)}")
    must_be_file(recording)
    from pelagos.viewer.film import FilmOptions, make_film

    kind = asked[0] if asked else "panels"
    wanted = FilmOptions(
        kind=kind,  # type: ignore[arg-type]
        sensor=options.camera or options.sonar or "",
        rate_hz=options.rate_hz,
        speed=options.speed,
    )
    columns = (TextColumn("filming"), BarColumn(), TextColumn("{task.completed}/{task.total}"), TimeRemainingColumn())
    with Progress(*columns, console=err, transient=True) as bar:
        task = bar.add_task("film", total=None)
        count = make_film(
            recording, target, wanted, progress=lambda done, total: bar.update(task, completed=done, total=total)
        )
    out.print(f"{count} pictures: {shown(target)}", markup=False)
