"""Scans as arrays: shapes and types, whose memory it is, and what is refused."""

from __future__ import annotations

import copy
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import relievo
from common import ROOT, SCANS

TRIANGLE = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
FACE = np.array([[0, 1, 2]])


def held(scan: relievo.Scan) -> Any:
    """All of a scan, to compare."""
    return scan._held.pickled()


def address(array: np.ndarray[Any, Any]) -> int:
    return int(array.__array_interface__["data"][0])


def test_arrays_have_the_shapes_and_types_that_are_documented() -> None:
    scan = relievo.read(SCANS / "bricks-hole.ply")
    vertices, faces = scan.n_vertices, scan.n_faces
    colors = scan.colors
    assert colors is not None
    table = [
        (scan.vertices, (vertices, 3), "float64"),
        (scan.faces, (faces, 3), "uint32"),
        (colors, (vertices, 3), "uint8"),
    ]
    for array, shape, dtype in table:
        assert (array.shape, array.dtype) == (shape, np.dtype(dtype))
        assert array.flags.c_contiguous and not array.flags.writeable
    assert list(scan.channels) == ["x", "y", "z", "red", "green", "blue"]
    assert [values.dtype.name for values in scan.channels.values()] == 3 * ["float64"] + 3 * ["uint8"]
    assert all(values.shape == (vertices,) for values in scan.channels.values())
    assert np.array_equal(np.stack([scan.channels[c] for c in "xyz"], axis=1), scan.vertices)
    assert np.array_equal(np.stack([scan.channels[c] for c in ("red", "green", "blue")], axis=1), colors)


@pytest.mark.parametrize("dtype", ["int8", "uint8", "int16", "uint16", "int32", "uint32", "float32", "float64"])
def test_channels_keep_their_type_and_values(dtype: str) -> None:
    kind = np.dtype(dtype)
    ends = [np.iinfo(kind).min, np.iinfo(kind).max] if kind.kind in "iu" else [np.finfo(kind).min, np.finfo(kind).tiny]
    values = np.array([*ends, 7], dtype=kind)
    scan = relievo.Scan(TRIANGLE, FACE, channels={"given": values})
    assert scan.channels["given"].dtype == kind
    assert np.array_equal(scan.channels["given"], values)
    assert not np.shares_memory(scan.channels["given"], values)


def test_channels_are_views_of_the_scans_own_memory() -> None:
    scan = relievo.Scan(TRIANGLE, FACE, channels={"label": np.array([1, 2, 3], np.uint8)})
    first, again = scan.channels["label"], scan.channels["label"]
    assert address(first) == address(again) and np.shares_memory(first, again)
    assert isinstance(first.base, relievo._relievo.Array)
    with pytest.raises(ValueError, match="read-only"):
        first[0] = 9
    with pytest.raises(ValueError, match="WRITEABLE"):
        first.flags.writeable = True


def test_vertices_faces_and_colors_are_made_once() -> None:
    scan = relievo.read(SCANS / "bricks-hole.ply")
    for name in ("vertices", "faces", "colors"):
        assert getattr(scan, name) is getattr(scan, name)
        with pytest.raises(ValueError, match="read-only"):
            getattr(scan, name)[0, 0] = 9


def test_views_outlive_the_scan() -> None:
    values = relievo.Scan(TRIANGLE, FACE, channels={"label": np.arange(3, dtype=np.int32)}).channels["label"]
    junk = [np.ones(3, np.int32) for _ in range(1000)]
    assert values.tolist() == [0, 1, 2] and len(junk) == 1000


def test_single_precision_stays_so() -> None:
    places = np.array([[0.1, 0.2, 0.3], [1.1, 0.2, 0.3], [0.1, 1.2, 0.3]], np.float32)
    scan = relievo.Scan(places, FACE)
    assert scan.channels["x"].dtype == np.float32
    assert scan.vertices.dtype == np.float64
    assert np.array_equal(scan.vertices, places.astype(np.float64))


@pytest.mark.parametrize(
    "places", [TRIANGLE.astype(">f8"), np.asfortranarray(TRIANGLE), TRIANGLE.astype(int), TRIANGLE.tolist()]
)
def test_any_order_in_memory_will_do(places: Any) -> None:
    assert np.array_equal(relievo.Scan(places, FACE[:, ::-1]).vertices, TRIANGLE)


def test_colors_of_every_type_are_bytes_when_read() -> None:
    reds = {"uint8": [255, 0, 51], "uint16": [65535, 0, 13107], "float32": [1, 0, 0.2], "float64": [1, 0, 0.2]}
    for dtype, red in reds.items():
        colors = np.zeros((3, 3), dtype)
        colors[:, 0] = red
        scan = relievo.Scan(TRIANGLE, FACE, colors=colors)
        assert scan.colors is not None
        assert scan.colors[:, 0].tolist() == [255, 0, 51], dtype
        assert scan.channels["red"].dtype == np.dtype(dtype)
    with_opacity = relievo.Scan(TRIANGLE, FACE, colors=np.full((3, 4), 7, np.uint8))
    assert list(with_opacity.channels)[3:] == ["red", "green", "blue", "alpha"]
    assert relievo.Scan(TRIANGLE, FACE).colors is None


def test_polygons_are_split_when_looked_at_and_kept_when_written(tmp_path: Path) -> None:
    square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    scan = relievo.Scan(square, [[0, 1, 2, 3]])
    assert (scan.n_faces, scan.faces.shape) == (1, (2, 3))
    relievo.write(scan, tmp_path / "square.off")
    assert (tmp_path / "square.off").read_text().splitlines()[-1].split()[:5] == ["4", "0", "1", "2", "3"]


def test_points_need_no_faces() -> None:
    for none in (None, [], np.empty((0, 3), int)):
        scan = relievo.Scan(TRIANGLE, none)
        assert scan.n_faces == 0 and scan.faces.shape == (0, 3)
        assert "points only" in repr(scan)


NAN = TRIANGLE.copy()
NAN[1, 2] = np.nan
WRONG: list[tuple[dict[str, Any], str]] = [
    ({"vertices": TRIANGLE[:, :2]}, r"vertices has the shape \(3, 2\); give one row of x, y and z a vertex"),
    ({"vertices": NAN}, "the scan: coordinate z of vertex 1 "),
    ({"vertices": np.empty((0, 3)), "faces": None}, "the scan holds no vertices"),
    ({"vertices": [["a", "b", "c"]]}, "vertices has the type"),
    ({"vertices": [[1, 2, 3], [1, 2]]}, "rows differ in length"),
    ({"vertices": TRIANGLE * 1j}, "give real numbers"),
    ({"faces": [[0, 1, 3]]}, "face 0 has the vertex 3, but there are only 3; count them from 0"),
    ({"faces": [[0, 1, 2], [0, -1, 2]]}, "face 1 has the vertex -1"),
    ({"faces": [[0, 1, 2**32]]}, "face 0 has the vertex 4294967296"),
    ({"faces": [[0, 1]]}, r"faces has the shape \(1, 2\)"),
    ({"faces": [[0.0, 1.0, 2.0]]}, "faces has the type float64; give whole numbers"),
    ({"faces": [[0, 1, 2], [0, 1]]}, "faces is no array: its rows differ in length"),
    ({"colors": np.zeros((2, 3), np.uint8)}, r"colors has the shape \(2, 3\)"),
    ({"colors": np.zeros((3, 3), np.int64)}, "colors has the type int64"),
    ({"channels": {"a": np.zeros(2)}}, r"the channel 'a' has the shape \(2,\)"),
    ({"channels": {"a": np.zeros(3, np.int64)}}, "the channel 'a' has the type int64.*convert it to one of"),
    ({"channels": {"x": np.zeros(3)}}, "the channel 'x' is there already; leave it out"),
    ({"channels": {"a b": np.zeros(3)}}, "the channel 'a b' cannot be called so"),
]


@pytest.mark.parametrize(("wrong", "sentence"), WRONG)
def test_wrong_arrays_are_refused_in_one_sentence(wrong: dict[str, Any], sentence: str) -> None:
    with pytest.raises(relievo.UsageError, match=sentence) as caught:
        relievo.Scan(**{"vertices": TRIANGLE, "faces": FACE, **wrong})
    assert isinstance(caught.value, ValueError) and caught.value.details == {}
    assert "\n" not in str(caught.value)


def scans_with_everything() -> list[Path]:
    found = sorted(
        path
        for path in (ROOT / "tests" / "samples").rglob("*")
        if path.suffix in {".ply", ".obj", ".ptx", ".pcd", ".e57", ".las"}
    )
    return [*found, *sorted(SCANS.glob("*.ply"))]


@pytest.mark.parametrize("path", scans_with_everything(), ids=lambda path: path.name)
def test_pickles_are_exact(path: Path) -> None:
    scan = relievo.read(path)
    for copied in (pickle.loads(pickle.dumps(scan)), copy.deepcopy(scan)):
        assert held(copied) == held(scan)
        assert list(copied.channels) == list(scan.channels)
        for name, values in scan.channels.items():
            assert copied.channels[name].tobytes() == values.tobytes(), name
            assert copied.channels[name].dtype == values.dtype


def test_what_is_no_scan_is_refused() -> None:
    for nonsense in (3, None, [1, 2], (TRIANGLE,), object()):
        with pytest.raises(relievo.UsageError, match="is no scan; give a relievo.Scan"):
            relievo.write(nonsense, "never-written.ply")  # type: ignore[arg-type]
    for function in (relievo.fit, relievo.complete, relievo.info):
        with pytest.raises(relievo.UsageError, match=r"give \(vertices, faces\), or relievo.Scan\(vertices\)"):
            function(TRIANGLE)  # type: ignore[arg-type]
