"""Types: of the package, of its native module, and of what users write."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from common import ROOT

SAMPLE = Path(__file__).with_name("typed_sample.py")


def python(*words: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", *words], capture_output=True, text=True, cwd=ROOT, timeout=300, check=False
    )


def test_the_package_and_a_users_program_pass_mypy() -> None:
    pytest.importorskip("mypy")
    done = python("mypy", "--strict", "-p", "relievo", "--config-file", str(ROOT / "pyproject.toml"))
    assert done.returncode == 0, done.stdout
    done = python("mypy", "--strict", str(SAMPLE), "--config-file", str(ROOT / "pyproject.toml"))
    assert done.returncode == 0, done.stdout


def test_mypy_sees_wrong_options(tmp_path: Path) -> None:
    pytest.importorskip("mypy")
    program = tmp_path / "wrong.py"
    program.write_text('import relievo\nrelievo.complete("a.ply", windw=4)\nrelievo.complete("a.ply", window="x")\n')
    done = python("mypy", "--strict", str(program), "--config-file", str(ROOT / "pyproject.toml"))
    assert 'Unexpected keyword argument "windw"' in done.stdout
    assert 'incompatible type "str"; expected "int | None"' in done.stdout


def test_the_native_module_is_what_its_stub_says() -> None:
    pytest.importorskip("mypy")
    done = python("mypy.stubtest", "relievo._relievo", "--concise")
    assert done.returncode == 0, done.stdout + done.stderr
