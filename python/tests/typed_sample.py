"""A user's program, for mypy alone."""

from __future__ import annotations

from pathlib import Path
from typing import Any, assert_type

import numpy as np
import numpy.typing as npt
import relievo
import trimesh


def complete_all(paths: list[Path]) -> list[relievo.Completed]:
    return [relievo.complete(path, holes=[3, 7], no_repair=["weld"], memory="500M", seed=1) for path in paths]


def figures(scan: relievo.Scan) -> None:
    assert_type(scan.vertices, npt.NDArray[np.float64])
    assert_type(scan.faces, npt.NDArray[np.uint32])
    assert_type(scan.colors, npt.NDArray[np.uint8] | None)
    assert_type(scan.channels["x"], npt.NDArray[Any])
    assert_type(relievo.holes(scan)["loops"][0]["id"], int)
    assert_type(relievo.fit(scan, base="sphere")["rms"], float)
    assert_type(relievo.complete((scan.vertices, scan.faces)).report["counts"]["completed_vertices"], int)
    assert_type(relievo.render(scan), npt.NDArray[np.uint8])
    mesh: trimesh.Trimesh = scan.to_trimesh()
    textured = relievo.texture(mesh, np.zeros((8, 8, 3), np.uint8), vertices=1000)
    relievo.write(textured.scan, Path("textured.ply"), overwrite=True)
    given: relievo.ScanLike = mesh
    relievo.write(given, "mesh.ply")
