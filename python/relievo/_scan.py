"""Scans: what every function takes and most give back."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from . import _arrays, _relievo, _trimesh
from ._errors import UsageError, WriteError

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt
    import trimesh

    from ._types import ArrayLike, PathLike, ScanLike


class Scan:
    """A scan in memory: vertices, faces, and every channel that the file has, in the file's own types.

    Scans do not change. All arrays that they give are read-only; ``array.copy()`` is yours.

    Parameters
    ----------
    vertices : (V, 3) array of finite numbers
        Coordinates, in any unit. ``float32`` stays so; all else becomes ``float64``.
    faces : (F, k) array of integers, k ≥ 3, optional
        Corners of the faces: rows of ``vertices``, counterclockwise as seen from outside. Without faces the scan is
        points, which functions that need a surface join first.
    colors : (V, 3) or (V, 4) array, optional
        Red, green, blue (and opacity): ``uint8`` up to 255, ``uint16`` up to 65535, or floating-point numbers up to 1.
    channels : mapping of str to (V,) arrays, optional
        Further numbers for each vertex, kept in their type: ``int8`` to ``uint32``, ``float32`` or ``float64``.

    All arrays are copied.

    Raises
    ------
    UsageError
        One of the arrays has the wrong shape or type, or names a vertex that does not exist.

    Examples
    --------
    >>> import numpy as np
    >>> scan = Scan([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]], channels={"label": np.uint8([1, 2, 3])})
    >>> scan
    <relievo.Scan: 3 vertices, 1 face, channels x, y, z, label>
    >>> scan.vertices[1]
    array([1., 0., 0.])
    """

    __slots__ = ("_cached", "_held")

    _held: _relievo.HeldScan
    _cached: dict[str, Any]

    def __init__(
        self,
        vertices: ArrayLike,
        faces: ArrayLike | None = None,
        colors: ArrayLike | None = None,
        channels: Mapping[str, ArrayLike] | None = None,
    ) -> None:
        columns = _arrays.columns_of(vertices, colors, channels or {})
        corners = None if faces is None else _arrays.faces_of(faces, len(columns[0][1]))
        self._held = _relievo.HeldScan.of_columns(columns, corners)
        self._cached = {}

    @classmethod
    def _of_held(cls, held: _relievo.HeldScan) -> Scan:
        scan = cls.__new__(cls)
        scan._held = held
        scan._cached = {}
        return scan

    @classmethod
    def from_trimesh(cls, mesh: trimesh.Trimesh) -> Scan:
        """The scan of a ``trimesh.Trimesh``: its vertices, triangles and colours (of vertices, or of a texture there).

        A texture is read at the vertices; what it has between them is lost, which is logged. Colours of faces, and
        attributes that are no numbers for each vertex, are lost, too.
        """
        return _trimesh.scan_of(mesh)

    def to_trimesh(self) -> trimesh.Trimesh:
        """The scan as a ``trimesh.Trimesh``: a copy, vertices and triangles in the same order.

        Colours become colours of its vertices, the other channels ``vertex_attributes``.
        """
        return _trimesh.mesh_of(self)

    @property
    def vertices(self) -> npt.NDArray[np.float64]:
        """(V, 3) coordinates: made once from the channels ``x``, ``y`` and ``z``, exact."""
        made: npt.NDArray[np.float64] = self._once("vertices", self._held.positions)
        return made

    @property
    def faces(self) -> npt.NDArray[np.uint32]:
        """(T, 3) corners of the triangles: the faces in their order, those with more corners split; made once."""
        made: npt.NDArray[np.uint32] = self._once("faces", self._held.triangles)
        return made

    @property
    def colors(self) -> npt.NDArray[np.uint8] | None:
        """(V, 3) red, green and blue from 0 to 255, whatever their type in the file; ``None`` without; made once."""
        made: npt.NDArray[np.uint8] | None = self._once("colors", self._held.colors)
        return made

    @property
    def channels(self) -> Mapping[str, npt.NDArray[Any]]:
        """Every number that the scan has for its vertices, by name, in the file's order and type: (V,) views of the
        scan's own memory, ``x``, ``y`` and ``z`` among them. Lists are not in it, but are kept."""
        return Channels(self._held)

    @property
    def n_vertices(self) -> int:
        """Number of vertices."""
        return self._held.vertex_count

    @property
    def n_faces(self) -> int:
        """Number of faces, of any number of corners; 0 for points."""
        return self._held.face_count

    def _once(self, name: str, make: Callable[[], _relievo.Array | None]) -> Any:
        if name not in self._cached:
            made = make()
            self._cached[name] = None if made is None else _arrays.view(made)
        return self._cached[name]

    def __repr__(self) -> str:
        faces = f"{self.n_faces} face{'' if self.n_faces == 1 else 's'}" if self.n_faces else "points only"
        return f"<relievo.Scan: {self.n_vertices} vertices, {faces}, channels {', '.join(self.channels)}>"

    def __reduce__(self) -> tuple[Any, ...]:
        return (_unpickled, self._held.pickled())


def _unpickled(ply: bytes, sensors: list[tuple[int, int, list[float]]]) -> Scan:
    return Scan._of_held(_relievo.HeldScan.of_pickle(ply, sensors))


class Channels(Mapping[str, "npt.NDArray[Any]"]):
    """The numbers of a scan's vertices by name: (V,) read-only views."""

    __slots__ = ("_held", "_indices")

    def __init__(self, held: _relievo.HeldScan) -> None:
        self._held = held
        self._indices: dict[str, int] = {}
        for name, index in held.channels():
            self._indices.setdefault(name, index)

    def __getitem__(self, name: str) -> npt.NDArray[Any]:
        return _arrays.view(self._held.channel(self._indices[name]))

    def __iter__(self) -> Iterator[str]:
        return iter(self._indices)

    def __len__(self) -> int:
        return len(self._indices)

    def __repr__(self) -> str:
        return f"<channels {', '.join(self)}>"


def read(
    path: PathLike,
    *,
    columns: list[str] | None = None,
    intrinsics: tuple[float, float, float, float] | None = None,
    color_image: PathLike | None = None,
) -> Scan:
    """Reads a scan: PLY, OBJ, STL, OFF, GLB, glTF, XYZ, PTS, TXT, CSV, PTX, PCD, E57, LAS, LAZ, or a depth image.

    Parameters
    ----------
    path : path of the file
    columns : names, optional
        What the columns of a text file without a line of names are, as in ``["x", "y", "z", "intensity"]``; ``"-"``
        skips one. By default guessed.
    intrinsics : (fx, fy, cx, cy) in pixels
        The camera of a depth image: focal lengths and principal point.
    color_image : path, optional
        A colour image of the same size as the depth image.

    Raises
    ------
    MissingFileError, ReadError
        There is no such file, or it cannot be read, or is broken; the message says what to do.
    """
    _arrays.check_intrinsics(intrinsics)
    return Scan._of_held(
        _relievo.read(
            os.fspath(path),
            columns,
            intrinsics,
            None if color_image is None else os.fspath(color_image),
        )
    )


def write(scan: ScanLike, path: PathLike, *, ascii: bool = False, overwrite: bool = False) -> None:
    """Writes a scan, in the format of the extension: .ply, .obj, .off, .stl or .glb.

    The file appears when it is complete, or not at all. PLY keeps everything; what another format cannot hold is
    logged.

    Parameters
    ----------
    scan : Scan, path, trimesh.Trimesh, or (vertices, faces)
    path : path of the file
    ascii : write PLY as text
    overwrite : replace the file if there is one of this name

    Raises
    ------
    WriteError
        There is a file of this name already, or it cannot be written; nothing has changed then.
    UsageError
        Scans are not written in this format.
    """
    with opened(path, overwrite=overwrite) as output:
        output.write(scan_of(scan)._held, ascii)


@contextmanager
def opened(path: PathLike, *, overwrite: bool) -> Iterator[_relievo.Output]:
    """The output of a scan, checked before the work; without a scan written to it nothing is left behind."""
    check_output(path, overwrite=overwrite)
    output = _relievo.Output(os.fspath(path))
    try:
        yield output
    finally:
        output.close()


def check_output(path: PathLike, *, overwrite: bool) -> None:
    """Nothing is written over silently."""
    if not overwrite and os.path.exists(path) and not _is_stream(path):
        raise WriteError(f"{os.fspath(path)} is there already; give another name, or overwrite=True")


def _is_stream(path: PathLike) -> bool:
    """Devices and pipes are written to, not over."""
    return not (os.path.isfile(path) or os.path.isdir(path))


def scan_of(given: ScanLike) -> Scan:
    """A scan of anything that functions take for one."""
    if isinstance(given, Scan):
        return given
    if isinstance(given, (str, os.PathLike)):
        return read(given)
    if isinstance(given, tuple) and len(given) == 2:
        return Scan(*given)
    if _trimesh.is_trimesh(given):
        return Scan.from_trimesh(given)
    if hasattr(given, "__array_interface__"):
        raise UsageError("an array is no scan by itself; give (vertices, faces), or relievo.Scan(vertices) for points")
    if type(given).__module__.partition(".")[0] == "trimesh":
        raise UsageError(_trimesh.remedy(given))
    raise UsageError(
        f"a {type(given).__name__} is no scan; give a relievo.Scan, a path, a trimesh.Trimesh, "
        "or a tuple of vertices and faces"
    )
