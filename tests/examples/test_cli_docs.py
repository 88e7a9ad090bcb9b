"""What the README and the pages of the documentation show is run: Python, scenarios and commands."""

from __future__ import annotations

import re
import shlex
from pathlib import Path
from typing import Any

import pytest
import yaml

import pelagos as pl
from pelagos.cli.main import main

ROOT = Path(__file__).parents[2]
HARBOUR = "examples/harbour_survey.yaml"
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]


def blocks(page: Path, language: str) -> list[str]:
    """The fenced blocks of a page in one language."""
    return re.findall(rf"^```{language}\n(.*?)^```", page.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)


def scenarios() -> list[tuple[str, str]]:
    return [(page.name, text) for page in PAGES for text in blocks(page, "yaml") if "agents:" in text]


def commands() -> list[Any]:
    """Every `pelagos ...` line, without its comment; those that fly whole episodes are slow."""
    shown = "\n".join(text for page in PAGES for text in blocks(page, "sh"))
    found = [shlex.split(line, comments=True) for line in shown.splitlines() if line.startswith("pelagos ")]
    told = [shlex.join(words[1:]) for words in dict.fromkeys(map(tuple, found))]
    return [pytest.param(c, marks=pytest.mark.slow) if c.startswith("evaluate ") else c for c in told]


def first_runs() -> set[str]:
    """Of each scenario that no command checks, the first command that runs it; `survey.yaml` is the harbour's."""
    found = [c for c in commands() if isinstance(c, str) and c.startswith(("run ", "check "))]
    scenario = {c: HARBOUR if c.split()[1] == "survey.yaml" else c.split()[1] for c in found}
    checked = {scenario[c] for c in scenario if c.startswith("check ")}
    runs = [c for c in scenario if c.startswith("run ") and scenario[c] not in checked]
    return set({scenario[c]: c for c in reversed(runs)}.values())


def test_there_is_something_to_check() -> None:
    assert len(scenarios()) >= 2
    assert len(commands()) >= 8


@pytest.mark.parametrize(("page", "text"), scenarios())
def test_scenarios_of_the_documentation_are_valid(page: str, text: str) -> None:
    assert pl.load_scenario(yaml.safe_load(text)).agents


@pytest.mark.parametrize("command", commands())
def test_commands_of_the_documentation_are_understood(
    command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Commands that run for long are only checked, their scenario and changes; what is run is built once, the harbour
    by the README's Python.
    """
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(tmp_path / "minari"))
    first = next(text for page, text in scenarios() if page == "getting_started.md")
    for name in ("first.yaml", "survey.yaml"):
        (tmp_path / name).write_text(
            first if name == "first.yaml" else (ROOT / "examples/harbour_survey.yaml").read_text()
        )
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    words = shlex.split(command)
    if words[0] in ("recover", "replay", "bench", "explain", "train"):
        return
    if "--episodes" in words:
        words[words.index("--episodes") + 1] = "1"
    if words[0] == "sweep":
        words = ["check", words[1]]
    if words[0] == "dataset":
        words = [*words[:2], "--plan"]
    if words[0] == "run":
        changes = [word for at, word in enumerate(words) if words[at - 1] == "--set"]
        as_first = [] if command in first_runs() else ["--no-build"]
        words = ["check", words[1], *as_first, *(part for change in changes for part in ("--set", change))]
    elif words == ["check", HARBOUR]:
        words.append("--no-build")
    with pytest.raises(SystemExit) as caught:
        main(words)
    assert not caught.value.code


def test_python_of_getting_started_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    page = ROOT / "docs" / "getting_started.md"
    (tmp_path / "first.yaml").write_text(blocks(page, "yaml")[0])
    namespace: dict[str, object] = {}
    exec(blocks(page, "python")[0], namespace)
    assert (tmp_path / "first.mcap").stat().st_size > 10_000


def test_python_of_the_readme_runs(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.chdir(ROOT)
    shown = blocks(ROOT / "README.md", "python")[0]
    assert "range(400):  # two seconds" in shown
    exec(shown.replace("range(400)", "range(200)"), {})
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) > 6
    assert "(4, " in lines[0]
