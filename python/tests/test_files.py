"""Reading and writing."""

from __future__ import annotations

import errno
import logging
import os
import pickle
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import relievo
from common import ROOT, SCANS, Command

TRIANGLE = (np.eye(3), [[0, 1, 2]])


def test_a_file_read_and_written_is_what_the_command_line_converts_it_to(command: Command, tmp_path: Path) -> None:
    for extension in ("ply", "obj", "glb", "off", "stl"):
        relievo.write(relievo.read(SCANS / "bricks-hole.ply"), tmp_path / f"ours.{extension}")
        command("convert", SCANS / "bricks-hole.ply", tmp_path / f"theirs.{extension}")
        assert (tmp_path / f"ours.{extension}").read_bytes() == (tmp_path / f"theirs.{extension}").read_bytes()


def test_ply_is_written_as_text_on_request(tmp_path: Path) -> None:
    relievo.write(TRIANGLE, tmp_path / "a.ply", ascii=True)
    assert b"format ascii 1.0" in (tmp_path / "a.ply").read_bytes()
    assert np.array_equal(relievo.read(tmp_path / "a.ply").vertices, np.eye(3))


def test_nothing_is_written_over_unasked(tmp_path: Path) -> None:
    path = tmp_path / "a.ply"
    relievo.write(TRIANGLE, path)
    before = path.read_bytes()
    with pytest.raises(relievo.WriteError, match="is there already; give another name, or overwrite=True"):
        relievo.write((np.eye(3) + 1, [[0, 1, 2]]), path)
    assert path.read_bytes() == before
    relievo.write((np.eye(3) + 1, [[0, 1, 2]]), path, overwrite=True)
    assert path.read_bytes() != before
    assert os.listdir(tmp_path) == ["a.ply"]


def test_what_cannot_be_written_leaves_nothing_behind(tmp_path: Path) -> None:
    with pytest.raises(relievo.WriteError, match="no folder|no such folder|folder"):
        relievo.write(TRIANGLE, tmp_path / "missing" / "a.ply")
    for name in ("a.las", "a.foo", "a"):
        with pytest.raises(relievo.UsageError, match="scans are written as .ply, .obj, .off, .stl or .glb"):
            relievo.write(TRIANGLE, tmp_path / name)
    with pytest.raises(relievo.MissingFileError):
        relievo.write(tmp_path / "missing.ply", tmp_path / "a.ply")
    assert os.listdir(tmp_path) == []


def test_errors_of_files_are_of_several_kinds(tmp_path: Path) -> None:
    with pytest.raises(relievo.MissingFileError, match="there is no such file; check the path") as caught:
        relievo.read(tmp_path / "missing.ply")
    assert isinstance(caught.value, (relievo.ReadError, FileNotFoundError))
    assert caught.value.errno == pickle.loads(pickle.dumps(caught.value)).errno == errno.ENOENT
    (tmp_path / "broken.ply").write_bytes((SCANS / "bricks-hole.ply").read_bytes()[:5000])
    with pytest.raises(relievo.ReadError, match="is cut off") as broken:
        relievo.read(tmp_path / "broken.ply")
    assert isinstance(broken.value, OSError) and not isinstance(broken.value, FileNotFoundError)
    again = pickle.loads(pickle.dumps(broken.value))
    assert type(again) is relievo.ReadError and str(again) == str(broken.value)


@pytest.mark.skipif(sys.platform != "linux", reason="names are text there")
def test_names_that_are_no_text_are_read_but_not_written(tmp_path: Path) -> None:
    path = os.fsdecode(os.fsencode(tmp_path) + b"/caf\xe9.ply")
    relievo.write(SCANS / "bricks-hole.ply", path)
    assert relievo.info(path)["vertices"] == relievo.read(path).n_vertices
    assert relievo.compare(path, SCANS / "bricks-hole.ply", pieces=64)["a"] is not None
    with pytest.raises(relievo.UsageError, match="not valid Unicode"):
        relievo.render(path, path + ".png")


def test_columns_and_cameras_are_given_as_options(tmp_path: Path) -> None:
    (tmp_path / "a.xyz").write_text("0 0 0 7\n1 0 0 8\n0 1 0 9\n")
    scan = relievo.read(tmp_path / "a.xyz", columns=["x", "y", "z", "label"])
    assert scan.channels["label"].tolist() == [7, 8, 9]
    for wrong in ((1, 2, 3), (0, 1, 1, 1), (1, 1, float("nan"), 1)):
        with pytest.raises(relievo.UsageError, match="give focal lengths above 0"):
            relievo.read(tmp_path / "a.xyz", intrinsics=wrong)  # type: ignore[arg-type]


def test_messages_go_to_the_logger(caplog: pytest.LogCaptureFixture, tmp_path: Path) -> None:
    with caplog.at_level(logging.WARNING, "relievo"):
        relievo.write(SCANS / "bricks-hole.ply", tmp_path / "a.stl")
    assert [record.name for record in caplog.records] == ["relievo"]
    assert caplog.records[0].levelno == logging.WARNING
    assert "red" in caplog.text


def test_messages_name_options_as_python_does(caplog: pytest.LogCaptureFixture) -> None:
    scan = relievo.read(SCANS / "golf-ball-half.ply")
    twice = relievo.Scan(np.concatenate([scan.vertices, scan.vertices]), np.concatenate([scan.faces, scan.faces]))
    with caplog.at_level(logging.DEBUG, "relievo"):
        relievo.fit(twice)
    assert caplog.text and "--" not in caplog.text


def test_importing_imports_neither_numpy_nor_trimesh() -> None:
    code = "import relievo, sys; assert not {'numpy', 'trimesh', 'dask'} & set(sys.modules)"
    subprocess.run([sys.executable, "-c", code], check=True)


def test_a_fork_of_a_process_that_has_worked_says_so() -> None:
    if not hasattr(os, "fork"):
        pytest.skip("this system has no forks")
    code = f"""
import os, relievo
relievo.read({str(SCANS / "bricks-hole.ply")!r})
child = os.fork()
if child == 0:
    try:
        relievo.read({str(SCANS / "bricks-hole.ply")!r})
    except relievo.UsageError as error:
        os._exit(0 if "spawn" in str(error) else 2)
    os._exit(1)
assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0
"""
    subprocess.run([sys.executable, "-c", code], check=True, timeout=60)


def test_the_version_is_the_programs(command: Command) -> None:
    assert command("--version").stdout.split() == ["relievo", relievo.__version__]
    manifest = (ROOT / "Cargo.toml").read_text()
    assert f'version = "{relievo.__version__}"' in manifest
