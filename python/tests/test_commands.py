"""The functions that are commands: they do what the command line does, on whatever they are given."""

from __future__ import annotations

import json
import logging
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import relievo
from common import SCANS, Command

BRICKS = SCANS / "bricks-hole.ply"
HALF = SCANS / "golf-ball-half.ply"


@pytest.fixture(scope="module")
def completed(golf_ball: Path) -> relievo.Completed:
    return relievo.complete(golf_ball)


def test_the_bytes_are_those_of_the_command_line(command: Command, tmp_path: Path, golf_ball: Path) -> None:
    cases: list[tuple[Path, list[str], dict[str, Any]]] = [
        (golf_ball, [], {}),
        (golf_ball, ["--seed", "3", "--window", "5", "--memory", "1M"], {"seed": 3, "window": 5, "memory": "1M"}),
        (BRICKS, ["--holes", "largest", "--blend=no"], {"holes": "largest", "blend": False}),
        (HALF, ["--extend", "--no-repair=weld,spikes"], {"extend": True, "no_repair": ["weld", "spikes"]}),
    ]
    for k, (path, words, options) in enumerate(cases):
        theirs, ours, told = (tmp_path / f"{name}{k}" for name in ("theirs.ply", "ours.ply", "told.json"))
        theirs, ours = theirs.with_suffix(f".{k}.ply"), ours.with_suffix(f".{k}.ply")
        command("complete", path, "-o", theirs, "--json", told, *words)
        for given in (path, relievo.read(path)):
            done = relievo.complete(given, **options)
            relievo.write(done.scan, ours, overwrite=True)
            assert ours.read_bytes() == theirs.read_bytes()
        report = json.loads(told.read_text())
        assert relievo.fit(path)["input"] == str(path) and "input" not in relievo.fit(relievo.read(path))
        for member in ("counts", "fit", "chosen", "filled", "skipped", "statistics"):
            assert done.report[member] == report[member], member  # type: ignore[literal-required]


def test_what_was_scanned_is_not_changed(golf_ball: Path, completed: relievo.Completed) -> None:
    before, after = relievo.read(golf_ball), completed.scan
    count = before.n_vertices
    assert after.n_vertices > count
    for name, values in before.channels.items():
        assert after.channels[name][:count].tobytes() == values.tobytes(), name
    assert np.array_equal(after.faces[: len(before.faces)], before.faces)
    assert after.channels["completed"].tolist() == count * [0] + (after.n_vertices - count) * [1]
    assert completed.report["counts"]["completed_vertices"] == after.n_vertices - count
    assert not completed.partly


def test_scans_are_taken_in_every_form(golf_ball: Path, completed: relievo.Completed) -> None:
    trimesh = pytest.importorskip("trimesh")
    scan = relievo.read(golf_ball)
    mesh = trimesh.Trimesh(scan.vertices, scan.faces, process=False)
    for given in (str(golf_ball), golf_ball, scan, (scan.vertices, scan.faces), mesh):
        again = relievo.complete(given).scan
        assert np.array_equal(again.vertices, completed.scan.vertices)
        assert np.array_equal(again.faces, completed.scan.faces)


def test_the_number_of_threads_does_not_matter(golf_ball: Path, completed: relievo.Completed) -> None:
    for threads in (1, 2, 3):
        assert np.array_equal(relievo.complete(golf_ball, threads=threads).scan.vertices, completed.scan.vertices)
    for wrong in (0, -1, "two", 1.5):
        with pytest.raises(relievo.UsageError, match="threads is"):
            relievo.complete(golf_ball, threads=wrong)  # type: ignore[arg-type]
        with pytest.raises(relievo.UsageError, match="threads is"):
            relievo.run([str(golf_ball)], threads=wrong)  # type: ignore[arg-type]


def test_numbers_of_numpy_are_numbers(golf_ball: Path) -> None:
    plain = relievo.complete(golf_ball, window=5, holes=[0])
    with_arrays = relievo.complete(golf_ball, window=np.int64(5), holes=np.array([0]))  # type: ignore[arg-type]
    assert np.array_equal(with_arrays.scan.vertices, plain.scan.vertices)
    more: dict[str, Any] = {"window": 5, "threads": np.int64(2), "seed": np.uint32(0)}
    for holes in ({0}, range(1)):
        with_sets = relievo.complete(golf_ball, holes=holes, **more)  # type: ignore[arg-type]
        assert np.array_equal(with_sets.scan.vertices, plain.scan.vertices)


def test_holes_are_listed_and_filled_by_number() -> None:
    listed = relievo.holes(BRICKS)
    assert listed["holes"] == 1 and listed["rims"] == 1
    hole = next(loop for loop in listed["loops"] if loop["kind"] == "hole")
    done = relievo.complete(BRICKS, holes=[hole["id"]])
    assert relievo.holes(done.scan)["holes"] == 0


def test_a_fit_tells_the_base_surface() -> None:
    fit = relievo.fit(HALF)
    assert fit["fits"] and fit["base"]["kind"] == "sphere"
    assert {candidate["base"]["kind"] for candidate in fit["ranking"]} == {"plane", "sphere", "cylinder", "cone"}


def test_statistics_and_comparison(completed: relievo.Completed, golf_ball: Path) -> None:
    stats = relievo.stats(completed.scan, pieces=64)
    assert stats["original"]["area"] > stats["completed"]["area"] > 0
    verdict = stats["verdict"]
    assert verdict is not None and "completed part" in verdict["text"]
    compared = relievo.compare(golf_ball, completed.scan, pieces=64)
    # All that was scanned is in both.
    assert compared["b"]["area"] > compared["a"]["area"] > 0
    parts = relievo.compare(completed.scan, part="completed=0", other_part="completed=1", pieces=64)
    assert parts["a"]["area"] == pytest.approx(stats["original"]["area"], rel=0.05)


def test_info_tells_what_is_in_a_scan() -> None:
    info = relievo.info(BRICKS)
    scan = relievo.read(BRICKS)
    assert (info["vertices"], info["faces"], info["colors"]) == (scan.n_vertices, scan.n_faces, True)
    assert np.allclose(info["extent"], [scan.vertices.min(axis=0), scan.vertices.max(axis=0)])


def test_texture_takes_arrays_paths_and_scans(tmp_path: Path, golf_ball: Path, command: Command) -> None:
    image = np.zeros((24, 24, 3), np.uint8)
    image[::4, :, 0] = 250
    textured = relievo.texture(golf_ball, image, vertices=3000, seed=1)
    colors = textured.scan.colors
    assert colors is not None
    assert set(np.unique(colors[:, 1])) == {0} and colors[:, 0].max() == 250
    from PIL import Image

    Image.fromarray(image).save(tmp_path / "sample.png")
    assert relievo.texture(golf_ball, tmp_path / "sample.png", vertices=3000, seed=1).scan.colors is not None
    theirs = tmp_path / "theirs.ply"
    command("texture", golf_ball, "-e", tmp_path / "sample.png", "--vertices", 3000, "--seed", 1, "-o", theirs)
    assert np.array_equal(relievo.read(theirs).vertices, textured.scan.vertices)
    assert np.array_equal(relievo.read(theirs).colors, colors)  # type: ignore[arg-type]
    of_scan = relievo.texture(golf_ball, relievo.read(BRICKS), vertices=3000)
    assert of_scan.scan.n_vertices > 0
    for wrong in (image[..., 0], image.astype(float), image[:0]):
        with pytest.raises(relievo.UsageError, match="exemplar has the shape .* give an image"):
            relievo.texture(golf_ball, wrong)


def test_a_mesh_with_texture_coordinates_is_written_with_an_image(tmp_path: Path) -> None:
    size = 12
    places = [(column, row) for row in range(size) for column in range(size)]
    lines = [f"v {x} {y} 0" for x, y in places] + [f"vt {x / (size - 1)} {y / (size - 1)}" for x, y in places]
    for row in range(size - 1):
        for column in range(size - 1):
            corner = row * size + column + 1
            square = (corner, corner + 1, corner + size + 1, corner + size)
            lines.append("f " + " ".join(f"{k}/{k}" for k in square))
    (tmp_path / "sheet.obj").write_text("\n".join(lines) + "\n")
    image = np.zeros((16, 16, 3), np.uint8)
    image[:, ::4, 1] = 200
    output = tmp_path / "textured.obj"
    done = relievo.texture(tmp_path / "sheet.obj", image, keep_mesh=True, vertices=2000, output=output)
    assert done.scan.n_vertices == size * size
    assert sorted(path.suffix for path in tmp_path.glob("textured*")) == [".mtl", ".obj", ".png"]
    with pytest.raises(relievo.WriteError, match="is there already"):
        relievo.texture(tmp_path / "sheet.obj", image, keep_mesh=True, vertices=2000, output=output)


def test_transfer_puts_colors_on_another_mesh(golf_ball: Path) -> None:
    scan = relievo.read(golf_ball)
    colors = np.zeros((scan.n_vertices, 3), np.uint8)
    colors[scan.vertices[:, 2] > 0] = 200
    source = relievo.Scan(scan.vertices, scan.faces, colors)
    done = relievo.transfer(source=source, target=scan, shape="position", channel="color", vertices=1000)
    got = done.scan.colors
    assert got is not None
    upper = done.scan.vertices[:, 2] > 2
    assert np.median(got[upper]) == 200
    assert np.median(got[done.scan.vertices[:, 2] < -2]) == 0


def test_pictures_are_arrays_or_files(tmp_path: Path, command: Command) -> None:
    picture = relievo.render(BRICKS, size=(160, 120))
    assert (picture.shape, picture.dtype) == ((120, 160, 3), np.dtype("uint8"))
    assert len(np.unique(picture.reshape(-1, 3), axis=0)) > 50
    again = relievo.render(relievo.read(BRICKS), tmp_path / "ours.png", size="160x120")
    assert np.array_equal(again, picture)
    assert relievo.render(BRICKS, size=(64, 48), background="transparent").shape == (48, 64, 4)
    command("render", BRICKS, "-o", tmp_path / "theirs.png", "--size", "160x120")
    assert (tmp_path / "ours.png").read_bytes() == (tmp_path / "theirs.png").read_bytes()


def test_a_page_is_written_on_request(tmp_path: Path, golf_ball: Path) -> None:
    relievo.complete(golf_ball, report=tmp_path / "page.html")
    assert (tmp_path / "page.html").read_text(encoding="utf-8").lstrip().lower().startswith("<!doctype html")


def test_a_closed_scan_cannot_be_completed(completed: relievo.Completed) -> None:
    with pytest.raises(relievo.WorkError, match="the scan") as caught:
        relievo.complete(completed.scan)
    assert isinstance(caught.value, RuntimeError)
    assert caught.value.details["seed"] == 0


def test_impossible_options_are_refused_in_one_sentence(golf_ball: Path) -> None:
    wrong: list[tuple[dict[str, Any], str]] = [
        ({"window": -1}, "window"),
        ({"window": 2.5}, "window"),
        ({"base": "cube"}, "base"),
        ({"holes": [999]}, "999"),
        ({"memory": "2 Gold"}, "memory"),
        ({"tolerance": float("nan")}, "a value that cannot be"),
        ({"mask": object()}, "is no number, text or list"),
        ({"no_repair": ["wld"]}, "wld"),
    ]
    for options, sentence in wrong:
        with pytest.raises(relievo.UsageError, match=sentence) as caught:
            relievo.complete(golf_ball, **options)
        assert "\n" not in str(caught.value) and "--" not in str(caught.value), options
    with pytest.raises(TypeError, match="windw"):
        relievo.complete(golf_ball, windw=4)  # type: ignore[call-arg]


def test_files_that_cannot_be_read_say_so_in_every_function(tmp_path: Path) -> None:
    for function in (relievo.complete, relievo.fit, relievo.holes, relievo.info, relievo.stats, relievo.render):
        with pytest.raises(relievo.MissingFileError, match="there is no such file"):
            function(tmp_path / "missing.ply")


def test_what_is_repaired_is_told(caplog: pytest.LogCaptureFixture) -> None:
    scan = relievo.read(HALF)
    twice = relievo.Scan(scan.vertices, np.concatenate([scan.faces, scan.faces[:5]]))
    with caplog.at_level(logging.WARNING, "relievo"):
        report = relievo.fit(twice)
    assert report["repair"]["duplicate_faces"] == 5
    assert "the scan: 5 face(s) left out that are there twice" in caplog.text


def test_pipelines_run_on_files_and_on_scans(tmp_path: Path, golf_ball: Path, completed: relievo.Completed) -> None:
    steps: list[Any] = [
        str(golf_ball),
        {"type": "complete"},
        {"type": "stats", "pieces": 64},
        str(tmp_path / "out.ply"),
    ]
    done = relievo.run(steps)
    assert done.scan is not None
    assert np.array_equal(done.scan.vertices, completed.scan.vertices)
    assert np.array_equal(relievo.read(tmp_path / "out.ply").vertices, completed.scan.vertices)
    (tmp_path / "steps.json").write_text(json.dumps({"pipeline": steps[:2]}))
    held = relievo.run({"pipeline": ["ball", {"type": "complete"}]}, scans={"ball": relievo.read(golf_ball)})
    from_file = relievo.run(tmp_path / "steps.json")
    for again in (held, from_file):
        assert again.scan is not None
        assert np.array_equal(again.scan.vertices, completed.scan.vertices)
    with pytest.raises(relievo.UsageError, match="complet"):
        relievo.run([str(golf_ball), {"type": "complet"}])
    with pytest.raises(relievo.MissingFileError, match="there is no such file"):
        relievo.run(tmp_path / "missing.json")
    (tmp_path / "broken.json").write_text("[1,")
    with pytest.raises(relievo.UsageError, match="broken.json: this is no JSON"):
        relievo.run(tmp_path / "broken.json")
    (tmp_path / "wrong.json").write_text('["a.ply", {"type": "complet"}]')
    with pytest.raises(relievo.UsageError, match="wrong.json: step 2 .*did you mean `complete`"):
        relievo.run(tmp_path / "wrong.json")
    assert (done.report["command"], done.report["status"]) == ("run", "done")


def test_a_batch_imports_nothing_from_the_working_folder(executable: Path, golf_ball: Path, tmp_path: Path) -> None:
    for name in ("json", "logging", "relievo"):
        (tmp_path / f"{name}.py").write_text("raise SystemExit('imported')")
    words = [str(executable), "batch", str(golf_ball), "--out", "out", "--step.complete.window=3"]
    done = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, timeout=300, check=False)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "out" / golf_ball.name).is_file()
