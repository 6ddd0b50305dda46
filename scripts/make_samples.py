"""Writes tests/samples: one small coloured sheet, as other programs write it in each format.

    python3 -m venv venv
    venv/bin/pip install numpy trimesh open3d 'laspy[lazrs]' pye57 pillow tifffile pymeshlab pypcd4
    venv/bin/python scripts/make_samples.py

The sheet has 6 by 6 vertices: the one in row r and column c (number i = 6 r + c) is at (c/10, r/10, sin(i)/50), its
colour is (5 i, 255 - 5 i, 100 + i). tests/samples.rs knows that, and reads every file by it. PTX and strips,
which none of these programs writes, are written here after the format's description.
"""

import json
import struct
import sys
from pathlib import Path

import laspy
import numpy as np
import open3d as o3d
import pye57
import pymeshlab
import tifffile
import trimesh
from PIL import Image

OUT = Path(__file__).resolve().parent.parent / "tests" / "samples"
N = 6
I = np.arange(N * N)
POINTS = np.stack([(I % N) / 10, (I // N) / 10, np.sin(I) / 50], axis=1)
COLORS = np.stack([5 * I, 255 - 5 * I, 100 + I], axis=1).astype(np.uint8)
FACES = np.array(
    [
        t
        for r in range(N - 1)
        for c in range(N - 1)
        for a in [r * N + c]
        for t in ([a, a + 1, a + N + 1], [a, a + N + 1, a + N])
    ]
)


def path(target, name):
    folder = OUT / target
    folder.mkdir(parents=True, exist_ok=True)
    return str(folder / name)


def with_trimesh():
    rgba = np.column_stack([COLORS, np.full(len(COLORS), 255, np.uint8)])
    mesh = trimesh.Trimesh(POINTS, FACES, vertex_colors=rgba, process=False)
    mesh.export(path("ply", "trimesh_binary.ply"))
    mesh.export(path("ply", "trimesh_ascii.ply"), encoding="ascii")
    mesh.export(path("obj", "trimesh.obj"))
    mesh.export(path("off", "trimesh.off"))
    mesh.export(path("stl", "trimesh_binary.stl"))
    mesh.export(path("stl", "trimesh_ascii.stl"), file_type="stl_ascii")
    mesh.export(path("gltf", "trimesh.glb"))
    trimesh.PointCloud(POINTS, colors=rgba).export(path("ply", "trimesh_points.ply"))
    trimesh.PointCloud(POINTS).export(path("xyz", "trimesh.xyz"))


def with_open3d():
    mesh = o3d.geometry.TriangleMesh(
        o3d.utility.Vector3dVector(POINTS), o3d.utility.Vector3iVector(FACES)
    )
    mesh.vertex_colors = o3d.utility.Vector3dVector(COLORS / 255)
    mesh.compute_vertex_normals()
    for target, name, text in [
        ("ply", "open3d_binary.ply", False),
        ("ply", "open3d_ascii.ply", True),
        ("obj", "open3d.obj", True),
        ("off", "open3d.off", True),
        ("stl", "open3d.stl", False),
        ("gltf", "open3d.glb", False),
    ]:
        assert o3d.io.write_triangle_mesh(path(target, name), mesh, write_ascii=text), name
    cloud = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(POINTS))
    cloud.colors = mesh.vertex_colors
    for target, name, text, compressed in [
        ("pcd", "open3d_ascii.pcd", True, False),
        ("pcd", "open3d_binary.pcd", False, False),
        ("pcd", "open3d_compressed.pcd", False, True),
        ("xyz", "open3d.xyz", True, False),
        ("xyz", "open3d.pts", True, False),
    ]:
        file = path(target, name)
        assert o3d.io.write_point_cloud(file, cloud, write_ascii=text, compressed=compressed)
    cloud.normals = mesh.vertex_normals
    o3d.io.write_point_cloud(path("pcd", "open3d_normals.pcd"), cloud)


def with_meshlab():
    rgba = np.column_stack([COLORS / 255, np.ones(len(COLORS))])
    mesh = pymeshlab.Mesh(
        vertex_matrix=POINTS, face_matrix=FACES, v_color_matrix=rgba, v_scalar_array=I.astype(float)
    )
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(mesh)
    for target, name in [("ply", "meshlab.ply"), ("obj", "meshlab.obj"), ("off", "meshlab.off")]:
        meshes.save_current_mesh(path(target, name), save_vertex_color=True)
    meshes.save_current_mesh(path("stl", "meshlab.stl"))
    for leftover in (OUT / "obj").glob("*.mtl"):
        leftover.unlink()


def with_numpy():
    table = np.column_stack([POINTS, COLORS])
    np.savetxt(path("xyz", "numpy.txt"), table, fmt=["%.9g"] * 3 + ["%d"] * 3)
    np.savetxt(
        path("xyz", "numpy.csv"), table, fmt=["%.9g"] * 3 + ["%d"] * 3, delimiter=",",
        header="X,Y,Z,R,G,B", comments="",
    )


def with_laspy():
    for name, version, point_format in [("laspy12.las", "1.2", 2), ("laspy14.las", "1.4", 7), ("laspy.laz", "1.4", 7)]:
        header = laspy.LasHeader(point_format=point_format, version=version)
        header.offsets, header.scales = [0, 0, 0], [1e-6] * 3
        las = laspy.LasData(header)
        las.x, las.y, las.z = POINTS.T
        las.red, las.green, las.blue = COLORS.T.astype(np.uint16) * 257
        las.intensity = I * 100
        las.write(path("las", name))


def with_pye57():
    file = path("e57", "pye57.e57")
    Path(file).unlink(missing_ok=True)
    with pye57.E57(file, mode="w") as e57:
        data = {f"cartesian{a}": POINTS[:, k] for k, a in enumerate("XYZ")}
        data |= {f"color{name}": COLORS[:, k] for k, name in enumerate(["Red", "Green", "Blue"])}
        data |= {"intensity": I / 36.0}
        e57.write_scan_raw(data)


def with_pillow_and_tifffile():
    depth = 1000 + 10 * I.reshape(N, N)
    depth[2, 3] = 0
    Image.fromarray(depth.astype(np.uint16)).save(path("depth", "pillow.png"))
    tifffile.imwrite(path("depth", "tifffile.tif"), depth.astype(np.float32))
    tifffile.imwrite(path("depth", "tifffile16.tif"), depth.astype(np.uint16))


def by_description():
    lines = [str(N), str(N), "0 0 2", "1 0 0", "0 1 0", "0 0 1"]
    lines += ["1 0 0 0", "0 1 0 0", "0 0 1 0", "0 0 0 1"]
    for c in range(N):
        for r in range(N):
            i = r * N + c
            # The origin would be taken for a missing point.
            x, y, z = POINTS[i] if i else (0, 0, 1e-6)
            lines.append(f"{x:.9g} {y:.9g} {z:.9g} 0.5 {' '.join(map(str, COLORS[i]))}")
    Path(path("ptx", "grid.ptx")).write_text("\n".join(lines) + "\n")

    strip = []
    for r in range(N - 1):
        strip += [v for c in range(N) for v in ((r + 1) * N + c, r * N + c)] + [-1]
    header = (
        "ply\nformat binary_big_endian 1.0\nelement vertex 36\n"
        + "".join(f"property float {a}\n" for a in "xyz")
        + "".join(f"property uchar {a}\n" for a in ["red", "green", "blue"])
        + "element tristrips 1\nproperty list int int vertex_indices\nend_header\n"
    )
    rows = b"".join(struct.pack(">3f3B", *p, *c) for p, c in zip(POINTS, COLORS))
    strips = struct.pack(f">i{len(strip)}i", len(strip), *strip)
    Path(path("ply", "strips.ply")).write_bytes(header.encode() + rows + strips)

    buffer = POINTS.astype("<f4").tobytes() + FACES.astype("<u2").tobytes()
    import base64

    document = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "buffers": [
            {
                "byteLength": len(buffer),
                "uri": "data:application/octet-stream;base64," + base64.b64encode(buffer).decode(),
            }
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": 432},
            {"buffer": 0, "byteOffset": 432, "byteLength": 300},
        ],
        "accessors": [
            {
                "bufferView": 0, "componentType": 5126, "count": 36, "type": "VEC3",
                "min": POINTS.min(0).tolist(), "max": POINTS.max(0).tolist(),
            },
            {"bufferView": 1, "componentType": 5123, "count": 150, "type": "SCALAR"},
        ],
    }
    Path(path("gltf", "embedded.gltf")).write_text(json.dumps(document))


if __name__ == "__main__":
    failed = []
    for write in [
        with_trimesh, with_open3d, with_meshlab, with_numpy, with_laspy, with_pye57,
        with_pillow_and_tifffile, by_description,
    ]:
        try:
            write()
        except Exception as error:  # one program's trouble is not the others'
            failed.append(f"{write.__name__}: {error!r}")
    print("\n".join(failed) or "all written")
    sys.exit(bool(failed))
