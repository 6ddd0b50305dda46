"""Writes tests/broken: files that are wrong, each in one way.

    python3 scripts/make_broken.py && REGENERATE=1 cargo test --test broken

The second command notes what relievo says of each in tests/broken/expected.tsv: read the difference before it is
committed. Files of formats that are not text are made from those in tests/samples.
"""

import json
import shutil
import struct
import zlib
from pathlib import Path

TESTS = Path(__file__).resolve().parent.parent / "tests"
OUT = TESTS / "broken"
SAMPLES = TESTS / "samples"


def sample(name):
    return (SAMPLES / name).read_bytes()


def changed(data, at, new):
    return data[:at] + new + data[at + len(new):]


def ply(body="0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", vertex="", face="property list uchar int vertex_indices", **counts):
    v, f = counts.get("v", 3), counts.get("f", 1)
    fmt = counts.get("format", "ascii 1.0")
    axes = counts.get("axes", "xyz")
    properties = "".join(f"property float {a}\n" for a in axes)
    return (
        f"ply\nformat {fmt}\nelement vertex {v}\n{properties}{vertex}"
        f"element face {f}\n{face}\nend_header\n{body}"
    ).encode()


POINTS = "v 0 0 0\nv 1 0 0\nv 0 1 0\n"
SOLID = "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid a\n"

BROKEN = {
    # PLY: headers
    "empty.ply": b"",
    "only_magic.ply": b"ply\n",
    "not_a_ply.ply": b"Hello, world\n",
    "no_end_header.ply": b"ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\n",
    "unknown_format.ply": ply(format="utf8 1.0"),
    "negative_count.ply": ply(v=-3),
    "count_beyond_64_bits.ply": ply(v=99999999999999999999),
    "huge_vertex_count.ply": ply(v=4000000000),
    "huge_face_count.ply": ply(f=4000000000),
    "huge_binary_count.ply": ply("", v=2000000000, format="binary_little_endian 1.0"),
    "unknown_type.ply": ply(vertex="property quad red\n"),
    "property_twice.ply": ply(vertex="property float x\n"),
    "element_twice.ply": ply(face="element vertex 3\nproperty float x"),
    "property_first.ply": b"ply\nformat ascii 1.0\nproperty float x\nend_header\n",
    "no_z.ply": ply(axes="xy", body="0 0\n1 0\n0 1\n3 0 1 2\n"),
    "no_vertices.ply": ply(v=0, f=0, body=""),
    "no_indices.ply": ply(face="property uchar flags", body="0 0 0\n1 0 0\n0 1 0\n7\n"),
    "list_as_coordinate.ply": ply(axes="xy", vertex="property list uchar float z\n", body="0 0 1 0\n" * 3 + "3 0 1 2\n"),
    # PLY: rows
    "cut_in_vertices.ply": ply("0 0 0\n1 0 0\n"),
    "cut_in_faces.ply": ply("0 0 0\n1 0 0\n0 1 0\n3 0 1"),
    "short_row.ply": ply("0 0\n1 0 0\n0 1 0\n3 0 1 2\n"),
    "word_for_number.ply": ply("0 zero 0\n1 0 0\n0 1 0\n3 0 1 2\n"),
    "bytes_in_text.ply": ply("0 0 0\n1 0 0\n").replace(b"1 0 0", b"1 \xff\xfe 0"),
    "nan.ply": ply("0 0 0\n1 nan 0\n0 1 0\n3 0 1 2\n"),
    "infinite.ply": ply("0 0 0\n1 0 inf\n0 1 0\n3 0 1 2\n"),
    "index_too_large.ply": ply("0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n"),
    "index_negative.ply": ply("0 0 0\n1 0 0\n0 1 0\n3 0 1 -1\n"),
    "face_of_two.ply": ply("0 0 0\n1 0 0\n0 1 0\n2 0 1\n"),
    "float_indices.ply": ply("0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", face="property list uchar float vertex_indices"),
    "binary_cut.ply": sample("ply/trimesh_binary.ply")[:700],
    "binary_list_too_long.ply": ply("", v=1, format="binary_little_endian 1.0", face="property list uint int vertex_indices")
    + struct.pack("<3fI", 0, 0, 0, 0xFFFFFFF0),
    "strip_index.ply": sample("ply/strips.ply")[:-8] + struct.pack(">2i", 99, -1),
    "grid_size.ply": b"ply\nformat ascii 1.0\nobj_info num_cols 3\nobj_info num_rows 3\nelement vertex 1\nproperty float x\n"
    b"property float y\nproperty float z\nelement range_grid 4\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0\n0\n0\n0\n",
    # OBJ
    "empty.obj": b"",
    "two_coordinates.obj": b"v 0 0\n",
    "word.obj": b"v 0 0 0\nv 1 x 0\n",
    "vertex_zero.obj": (POINTS + "f 0 1 2\n").encode(),
    "vertex_missing.obj": (POINTS + "f 1 2 9\n").encode(),
    "negative_too_far.obj": (POINTS + "f -1 -2 -9\n").encode(),
    "face_of_two.obj": (POINTS + "f 1 2\n").encode(),
    "face_of_words.obj": (POINTS + "f one two three\n").encode(),
    "material_missing.obj": ("mtllib none.mtl\n" + POINTS + "usemtl a\nf 1 2 3\n").encode(),
    # OFF
    "empty.off": b"",
    "other_kind.off": b"4OFF\n1 0 0\n0 0 0 0\n",
    "no_counts.off": b"OFF\nmany few\n",
    "cut.off": sample("off/trimesh.off")[:900],
    "index.off": b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n",
    "counts_too_large.off": b"OFF\n4000000000 1 0\n0 0 0\n",
    # STL
    "empty.stl": b"",
    "cut_binary.stl": sample("stl/trimesh_binary.stl")[:1000],
    "count_too_large.stl": changed(sample("stl/trimesh_binary.stl"), 80, struct.pack("<I", 0xFFFFFFFF)),
    "cut_text.stl": SOLID.split("endloop")[0].encode(),
    "four_corners.stl": SOLID.replace("endloop", "vertex 1 1 0\nendloop").encode(),
    "word.stl": SOLID.replace("vertex 1 0 0", "vertex 1 o 0").encode(),
    "nan.stl": SOLID.replace("vertex 1 0 0", "vertex nan 0 0").encode(),
    # columns
    "empty.xyz": b"",
    "words.xyz": b"once upon a time\n",
    "ragged.xyz": b"0 0 0\n1 0 0 5\n2 0 0\n",
    "two_columns.xyz": b"0 1\n1 0\n",
    "word.csv": b"x,y,z\n0,0,0\n1,one,0\n",
    "no_z.csv": b"x,y,height\n0,0,0\n",
    "cut.pts": b"5\n0 0 0 1 2 3 4\n",
    "all_nan.xyz": b"nan nan nan\nnan nan nan\n",
    # PTX
    "empty.ptx": b"",
    "cut.ptx": sample("ptx/grid.ptx")[:600],
    "counts_too_large.ptx": sample("ptx/grid.ptx").replace(b"6\n6\n", b"60000\n60000\n", 1),
    "word.ptx": sample("ptx/grid.ptx").replace(b"0.5", b"half", 1),
    "no_matrix.ptx": b"2\n2\n0 0 0\n1 0 0\n",
    # PCD
    "empty.pcd": b"# .PCD v0.7\n",
    "no_data.pcd": sample("pcd/open3d_ascii.pcd").split(b"DATA")[0],
    "cut_binary.pcd": sample("pcd/open3d_binary.pcd")[:500],
    "cut_compressed.pcd": sample("pcd/open3d_compressed.pcd")[:400],
    "bad_compressed.pcd": sample("pcd/open3d_compressed.pcd")[:-40] + b"\xff" * 40,
    "counts_too_large.pcd": sample("pcd/open3d_binary.pcd").replace(b"POINTS 36", b"POINTS 3600000000").replace(b"WIDTH 36", b"WIDTH 3600000000"),
    "no_z.pcd": sample("pcd/open3d_ascii.pcd").replace(b"FIELDS x y z", b"FIELDS x y w"),
    # E57
    "empty.e57": b"ASTM-E57",
    "cut.e57": sample("e57/pye57.e57")[:3000],
    "checksum.e57": changed(sample("e57/pye57.e57"), 1200, b"\xaa\xbb\xcc"),
    "length.e57": changed(sample("e57/pye57.e57"), 16, struct.pack("<Q", 1 << 62)),
    # LAS, LAZ
    "empty.las": b"LASF",
    "cut.las": sample("las/laspy12.las")[:700],
    "cut.laz": sample("las/laspy.laz")[:900],
    "counts_too_large.las": changed(sample("las/laspy12.las"), 107, struct.pack("<I", 4000000000)),
    "offset_beyond.las": changed(sample("las/laspy12.las"), 96, struct.pack("<I", 4000000000)),
    # glTF
    "empty.glb": b"glTF",
    "cut.glb": sample("gltf/trimesh.glb")[:1500],
    "not_json.gltf": b"{ this is not JSON",
    "no_meshes.gltf": b'{"asset": {"version": "2.0"}}',
    "version.gltf": b'{"asset": {"version": "1.0"}}',
    "buffer_missing.gltf": None,
    "accessor_beyond.gltf": None,
    "index_beyond.gltf": None,
    "node_cycle.gltf": None,
    # depth images
    "cut.png": sample("depth/pillow.png")[:80],
    "not_an_image.png": b"\x89PNG\r\n\x1a\n" + b"\0" * 40,
    "all_missing.png": None,
    "bomb.png": None,
    "cut.tif": sample("depth/tifffile.tif")[:200],
    # others
    "unknown.docx": b"PK\x03\x04\x00\x00",
    "no_extension": b"Dear Sir or Madam\n",
}


def gltf(change):
    document = json.loads(sample("gltf/embedded.gltf"))
    change(document)
    return json.dumps(document).encode()


def png(width, height, rows):
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">2I5B", width, height, 16, 0, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")


BROKEN["buffer_missing.gltf"] = gltf(lambda d: d["buffers"][0].update(uri="none.bin"))
BROKEN["accessor_beyond.gltf"] = gltf(lambda d: d["accessors"][0].update(count=4000000000))
BROKEN["index_beyond.gltf"] = gltf(lambda d: d["meshes"][0]["primitives"][0].update(indices=9))
BROKEN["node_cycle.gltf"] = gltf(lambda d: d["nodes"][0].update(children=[0]))
BROKEN["all_missing.png"] = png(4, 4, b"\0" * 9 * 4)
BROKEN["bomb.png"] = png(200000, 200000, b"\0" * 1000)

if __name__ == "__main__":
    for old in OUT.glob("*"):
        if old.name != "expected.tsv":
            old.unlink()
    OUT.mkdir(exist_ok=True)
    for name, data in BROKEN.items():
        (OUT / name).write_bytes(data)
    print(len(BROKEN), "files")
