"""What several tests need."""

from __future__ import annotations

import subprocess
import sysconfig
from pathlib import Path

import pytest
from common import Command


@pytest.fixture(scope="session")
def executable() -> Path:
    """The command that was installed with the package under test."""
    return Path(sysconfig.get_path("scripts")) / "relievo"


@pytest.fixture(scope="session")
def command(executable: Path) -> Command:
    """Runs the command line."""

    def run(*arguments: object, code: int = 0) -> subprocess.CompletedProcess[str]:
        words = [str(executable), *(str(argument) for argument in arguments)]
        done = subprocess.run(words, capture_output=True, text=True, timeout=300, check=False)
        assert done.returncode == code, done.stderr
        return done

    return run


@pytest.fixture(scope="session")
def golf_ball(command: Command, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A small scan with a hole."""
    path = tmp_path_factory.mktemp("scans") / "golf-ball.ply"
    command("synth", "golf-ball", "--vertices", 3000, "-o", path)
    return path
