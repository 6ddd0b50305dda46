"""Meshes of trimesh, in and out."""

from __future__ import annotations

import logging

import numpy as np
import pytest
import relievo
from common import SCANS

trimesh = pytest.importorskip("trimesh")


def test_there_and_back_everything_is_the_same() -> None:
    scan = relievo.read(SCANS / "bricks-hole.ply")
    mesh = scan.to_trimesh()
    assert isinstance(mesh, trimesh.Trimesh)
    assert np.array_equal(mesh.vertices, scan.vertices) and np.array_equal(mesh.faces, scan.faces)
    back = relievo.Scan.from_trimesh(mesh)
    assert np.array_equal(back.vertices, scan.vertices)
    assert np.array_equal(back.faces, scan.faces)
    assert back.colors is not None and scan.colors is not None
    assert np.array_equal(back.colors, scan.colors)
    assert list(back.channels) == list(scan.channels)


def test_attributes_of_vertices_are_channels() -> None:
    scan = relievo.Scan(np.eye(3), [[0, 1, 2]], channels={"label": np.array([1, 2, 3], np.uint16)})
    mesh = scan.to_trimesh()
    assert mesh.vertex_attributes["label"].tolist() == [1, 2, 3]
    mesh.vertex_attributes["whole"] = np.array([1, 2, 3])
    back = relievo.Scan.from_trimesh(mesh)
    assert back.channels["label"].dtype == np.uint16
    assert back.channels["whole"].dtype == np.float64


def test_attributes_that_no_scan_can_have_are_lost_and_told(caplog: pytest.LogCaptureFixture) -> None:
    attributes = {name: np.arange(3, dtype=np.float16) for name in ("half", "a b", "x", "é")}
    attributes["red"] = np.arange(3, dtype=np.uint8)
    colors = np.full((3, 3), 9, np.uint8)
    mesh = trimesh.Trimesh(np.eye(3), [[0, 1, 2]], vertex_attributes=attributes, vertex_colors=colors, process=False)
    with caplog.at_level(logging.WARNING, "relievo"):
        scan = relievo.Scan.from_trimesh(mesh)
    assert list(scan.channels) == ["x", "y", "z", "red", "green", "blue", "half"]
    assert scan.channels["half"].dtype == np.float32
    assert scan.colors is not None and np.array_equal(scan.colors, colors)
    for lost in ("'a b'", "'x'", "'é'", "'red'"):
        assert f"attribute {lost} is lost" in caplog.text


def test_what_is_no_mesh_says_what_to_give() -> None:
    scene, cloud = trimesh.Scene(trimesh.Trimesh(np.eye(3), [[0, 1, 2]])), trimesh.PointCloud(np.eye(3))
    for given, words in ((scene, r"scene.to_mesh\(\)"), (cloud, r"relievo.Scan\(cloud.vertices\)"), (3, "give one")):
        with pytest.raises(relievo.UsageError, match=words):
            relievo.Scan.from_trimesh(given)
    with pytest.raises(relievo.UsageError, match="to_mesh"):
        relievo.info(scene)
    assert relievo.info(scene.to_mesh())["vertices"] == 3


def test_a_changed_copy_leaves_the_scan_as_it_is() -> None:
    scan = relievo.Scan(np.eye(3), [[0, 1, 2]])
    mesh = scan.to_trimesh()
    mesh.vertices[0] = 9
    assert np.array_equal(scan.vertices, np.eye(3))


def test_a_texture_becomes_colors_of_vertices_and_the_loss_is_told(caplog: pytest.LogCaptureFixture) -> None:
    from PIL import Image

    image = Image.fromarray(np.array([[[255, 0, 0], [0, 255, 0]]], np.uint8).repeat(2, axis=0))
    visual = trimesh.visual.TextureVisuals(uv=np.array([[0.0, 0], [1, 0], [0, 1]]), image=image)
    mesh = trimesh.Trimesh(np.eye(3), [[0, 1, 2]], visual=visual, process=False)
    with caplog.at_level(logging.WARNING, "relievo"):
        colors = relievo.Scan.from_trimesh(mesh).colors
    assert colors is not None
    assert colors.tolist() == [[255, 0, 0], [0, 255, 0], [255, 0, 0]]
    assert "only the colours at the vertices are kept" in caplog.text


def test_colors_of_faces_are_lost_and_told(caplog: pytest.LogCaptureFixture) -> None:
    mesh = trimesh.Trimesh(np.eye(3), [[0, 1, 2]], face_colors=[[1, 2, 3, 255]], process=False)
    with caplog.at_level(logging.WARNING, "relievo"):
        assert relievo.Scan.from_trimesh(mesh).colors is None
    assert "colours of faces, which are lost" in caplog.text
