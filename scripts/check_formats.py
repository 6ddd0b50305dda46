#!/usr/bin/env python3
"""Opens what relievo writes with three other programs' readers: trimesh, Open3D and MeshLab.

    python scripts/check_formats.py [--relievo PATH]

Two test scans with a hole (bricks has colours, golf-ball has none) are completed by relievo and written in every
format, by `convert` and by `complete -o` itself. Each file must open in each program with the same numbers of vertices
(not STL, which repeats them) and triangles, in the same order of triangles the same positions of their corners within
the precision of a float, and the same colours there within 1/255 (not STL, which has none). The numbering of vertices
may differ: Open3D's OBJ and glTF reader changes it. All is compared with the binary PLY, decoded here with numpy alone.

Prints a table; ends with 1 if anything differs. It needs

    pip install numpy trimesh open3d pymeshlab
    apt-get install libusb-1.0-0 libgl1 libgomp1 libopengl0    (for Open3D and MeshLab, where missing)
"""

import argparse
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import open3d
import pymeshlab
import trimesh

COLOR_STEP = 1 / 255
NAMES = ["ply", "ascii.ply", "obj", "stl", "off", "glb"]


def decode_ply(path):
    """Positions, triangles and colours (or None) of a binary PLY with vertex rows and lists of three indices."""
    header, data = path.read_bytes().split(b"end_header\n", 1)
    types = {"double": "<f8", "float": "<f4", "uchar": "u1", "int": "<i4"}
    counts, row = {}, []
    for line in header.decode().splitlines():
        words = line.split()
        if words[0] == "element":
            counts[words[1]] = int(words[2])
        elif words[0] == "property" and words[1] != "list":
            row.append((words[2], types[words[1]]))
    vertices = np.frombuffer(data, np.dtype(row), counts["vertex"])
    faces = np.dtype([("corners", "u1"), ("indices", "<i4", 3)])
    faces = np.frombuffer(data, faces, counts["face"], vertices.nbytes)
    assert (faces["corners"] == 3).all() and len(data) == vertices.nbytes + faces.nbytes, path
    positions = np.column_stack([vertices[name] for name in "xyz"])
    has_colors = "red" in vertices.dtype.names
    colors = np.column_stack([vertices[name] for name in ("red", "green", "blue")]) / 255 if has_colors else None
    return positions, faces["indices"].astype(np.int64), colors


def with_trimesh(path):
    """trimesh, which must not merge vertices (process=False); it reads no colours from OFF."""
    mesh = trimesh.load(path, process=False, force="mesh", maintain_order=True)
    colors = mesh.visual.vertex_colors[:, :3] / 255 if mesh.visual.kind == "vertex" else None
    return mesh.vertices, mesh.faces, colors


def with_open3d(path):
    """Open3D, which merges the corners of STL only."""
    mesh = open3d.io.read_triangle_mesh(str(path))
    colors = np.asarray(mesh.vertex_colors) if mesh.has_vertex_colors() else None
    return np.asarray(mesh.vertices), np.asarray(mesh.triangles), colors


def with_meshlab(path):
    """MeshLab."""
    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(str(path))
    mesh = meshes.current_mesh()
    colors = mesh.vertex_color_matrix()[:, :3] if mesh.has_vertex_color() else None
    return mesh.vertex_matrix(), mesh.face_matrix(), colors


# Each program, and the formats whose colours it does not read.
PROGRAMS = {"trimesh": (with_trimesh, {"off"}), "Open3D": (with_open3d, set()), "MeshLab": (with_meshlab, set())}


def difference(expected, found, is_stl, reads_colors):
    """What differs, in a few words, or an empty text."""
    positions, faces, colors = expected
    found_positions, found_faces, found_colors = found
    if len(faces) != len(found_faces):
        return f"{len(found_faces)} triangles, not {len(faces)}"
    if not is_stl and len(positions) != len(found_positions):
        return f"{len(found_positions)} vertices, not {len(positions)}"
    # A unit in the last place of a float at the scan's extent: half for writing, half for the reader's own rounding.
    tolerance = np.abs(positions).max() * np.finfo(np.float32).eps
    largest = np.abs(positions[faces] - found_positions[found_faces]).max()
    if not largest <= tolerance:
        return f"positions differ by up to {largest:.3g}"
    if is_stl or colors is None or not reads_colors:
        return ""
    if found_colors is None:
        return "no colours"
    largest = np.abs(colors[faces] - found_colors[found_faces]).max()
    return "" if largest <= COLOR_STEP + 1e-6 else f"colours differ by up to {largest * 255:.1f}/255"


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("--relievo", default=Path(__file__).parent.parent / "target/release/relievo")
    relievo = arguments.parse_args().relievo
    open3d.utility.set_verbosity_level(open3d.utility.VerbosityLevel.Error)
    bad = 0
    print(f"| scan | file | {' | '.join(PROGRAMS)} |\n|---|---|{'---|' * len(PROGRAMS)}")
    with tempfile.TemporaryDirectory() as folder:
        for kind in ["bricks", "golf-ball"]:
            scan, completed = Path(folder, f"{kind}.ply"), Path(folder, f"{kind}-completed.ply")

            def run(*words):
                subprocess.run([relievo, *words, "--quiet"], check=True)

            run("synth", kind, "--vertices", "3000", "-o", scan)
            run("complete", scan, "-o", completed)
            expected = decode_ply(completed)
            if len(expected[0]) <= len(decode_ply(scan)[0]) or (expected[2] is None) != (kind == "golf-ball"):
                sys.exit(f"{kind}: nothing was completed, or colours are missing")
            if len(np.unique(expected[1])) != len(expected[0]):
                sys.exit(f"{kind}: there are vertices without triangles, which would not be compared")
            for name in NAMES:
                ascii_option = ["--ascii"] if name == "ascii.ply" else []
                by_convert, by_complete = Path(folder, f"convert-{kind}.{name}"), Path(folder, f"complete-{kind}.{name}")
                run("convert", completed, by_convert, *ascii_option)
                run("complete", scan, "-o", by_complete, *ascii_option)
                for path in [by_convert, by_complete]:
                    cells = []
                    for program, (reader, colorless) in PROGRAMS.items():
                        try:
                            found, reads_colors = reader(path), path.suffix[1:] not in colorless
                            cells.append(difference(expected, found, path.suffix == ".stl", reads_colors))
                        except Exception as error:  # whatever another program's reader raises is the finding
                            cells.append(f"{type(error).__name__}: {error}".splitlines()[0])
                        bad += bool(cells[-1])
                    print(f"| {kind} | {path.name} | {' | '.join(cell or 'ok' for cell in cells)} |", flush=True)
    if bad:
        print(f"{bad} of the readings differ", file=sys.stderr)
    sys.exit(bad > 0)


if __name__ == "__main__":
    main()
