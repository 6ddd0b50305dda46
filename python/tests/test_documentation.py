"""What the documentation shows is tried, and the options are those of the command line."""

from __future__ import annotations

import doctest
import importlib
import inspect
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
import relievo
from common import ROOT

COMMANDS = ["compare", "complete", "fit", "holes", "info", "render", "stats", "texture", "transfer"]


@pytest.mark.parametrize("name", ["relievo", "relievo._scan", "relievo._commands", "relievo._call"])
def test_examples_do_what_they_show(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    module = importlib.import_module(name)
    failed, tried = doctest.testmod(module, extraglobs={"relievo": relievo}, optionflags=doctest.NORMALIZE_WHITESPACE)
    assert failed == 0
    assert tried > 0


def test_the_functions_are_what_the_schema_tells() -> None:
    script = ROOT / "scripts" / "make_python_commands.py"
    done = subprocess.run([sys.executable, str(script), "--check"], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("command", COMMANDS)
def test_options_and_defaults_are_those_of_the_command(command: str) -> None:
    parameters = inspect.signature(getattr(relievo, command)).parameters
    options: dict[str, dict[str, Any]] = relievo.schema()["$defs"][command]["properties"]
    of_files = {"type", "tag", "output", "ascii", "overwrite"}
    assert set(options) - of_files <= set(parameters)
    assert parameters["seed"].default == 0
    for name, option in options.items():
        if name in of_files or name in {"exemplar", "source", "other", "seed"}:
            continue
        assert parameters[name].kind is inspect.Parameter.KEYWORD_ONLY
        assert parameters[name].default == option.get("default"), name
        assert f"\n{name} : " in inspect.cleandoc(getattr(relievo, command).__doc__), name


def test_everything_public_is_documented() -> None:
    for name in relievo.__all__:
        thing = getattr(relievo, name)
        if callable(thing):
            assert thing.__doc__ and len(thing.__doc__) > 10, name
    for name, member in inspect.getmembers(relievo.Scan):
        if not name.startswith("_"):
            assert member.__doc__, name


def test_the_readme_shows_what_works(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    programs = [part.split("```")[0] for part in text.split("```python\n")[1:]]
    assert programs
    (tmp_path / "data").symlink_to(ROOT / "data")
    (tmp_path / "scans" / "walls").mkdir(parents=True)
    for name in ("scans/walls/wall.ply", "large.ply"):
        shutil.copy(ROOT / "data/scans/bricks-hole.ply", tmp_path / name)
    monkeypatch.chdir(tmp_path)
    for program in programs:
        exec(compile(program, "README.md", "exec"), {"__name__": "__main__"})
    for name in ("bricks.ply", "filled/walls/wall.ply", "large-filled.ply"):
        assert relievo.read(name).n_vertices > relievo.read("large.ply").n_vertices, name


def test_the_example_makes_its_figure(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    script = ROOT / "scripts" / "from_scan_to_figure.py"
    done = subprocess.run(
        [sys.executable, str(script), str(tmp_path)], capture_output=True, text=True, check=False, timeout=300
    )
    assert done.returncode == 0, done.stderr
    assert "new vertices" in done.stdout
    from PIL import Image

    with Image.open(tmp_path / "figure.png") as figure:
        assert figure.size == (1000, 800)
        colors = figure.convert("RGB").getcolors(1 << 24)
    assert colors is not None and len(colors) > 1000
    assert (
        relievo.read(tmp_path / "completed.ply").n_vertices
        > relievo.read(ROOT / "data/scans/bricks-hole.ply").n_vertices
    )
