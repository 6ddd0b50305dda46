"""What tests and their fixtures share."""

from __future__ import annotations

import subprocess
from collections.abc import Callable
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SCANS = ROOT / "data" / "scans"

Command = Callable[..., "subprocess.CompletedProcess[str]"]
