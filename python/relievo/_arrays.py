"""Arrays in and out, and what can be wrong with them, each in one sentence with a remedy.

numpy is imported where it is needed: the command line shares this package, and threads that numpy begins would take
the signals that the command line waits for.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence, Set
from typing import TYPE_CHECKING, Any

from . import _relievo
from ._errors import UsageError

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    from ._types import ArrayLike

# The types of a scan's numbers.
_TYPES = ("int8", "uint8", "int16", "uint16", "int32", "uint32", "float32", "float64")
_COLOR_TYPES = ("uint8", "uint16", "float32", "float64")
_COORDINATES = ("x", "y", "z")
_COLORS = ("red", "green", "blue", "alpha")


def view(array: _relievo.Array) -> npt.NDArray[Any]:
    """A numpy array on the same memory, read-only."""
    import numpy as np

    return np.asarray(array)


def columns_of(
    vertices: ArrayLike, colors: ArrayLike | None, channels: Mapping[str, ArrayLike]
) -> list[tuple[str, npt.NDArray[Any]]]:
    """The named columns of a scan's vertices."""
    places = _numbers("vertices", vertices)
    if places.ndim != 2 or places.shape[1] != 3:
        raise UsageError(f"vertices has the shape {places.shape}; give one row of x, y and z a vertex: (V, 3)")
    if places.dtype.name not in ("float32", "float64"):
        places = places.astype("float64")
    columns = [(name, places[:, k]) for k, name in enumerate(_COORDINATES)]
    if colors is not None:
        columns += _color_columns(colors, len(places))
    taken = {name for name, _ in columns}
    for name, values in channels.items():
        _check_name(name, taken)
        taken.add(name)
        columns.append((name, _channel(name, values, len(places))))
    return columns


def _numbers(what: str, values: ArrayLike) -> npt.NDArray[Any]:
    """An array of numbers in this machine's order of bytes."""
    array = _array(what, values)
    if array.dtype.kind not in "biuf":
        raise UsageError(f"{what} has the type {array.dtype}; give real numbers")
    if array.dtype.kind == "b":
        array = array.astype("uint8")
    if not array.dtype.isnative:
        array = array.astype(array.dtype.newbyteorder("="))
    return array


def _array(what: str, values: ArrayLike) -> npt.NDArray[Any]:
    import numpy as np

    try:
        return np.asarray(values)
    except ValueError:
        raise UsageError(f"{what} is no array: its rows differ in length") from None


def _color_columns(colors: ArrayLike, vertices: int) -> list[tuple[str, npt.NDArray[Any]]]:
    array = _numbers("colors", colors)
    if array.ndim != 2 or array.shape[0] != vertices or array.shape[1] not in (3, 4):
        raise UsageError(
            f"colors has the shape {array.shape}; give one row of red, green and blue a vertex: ({vertices}, 3)"
        )
    if array.dtype.name not in _COLOR_TYPES:
        raise UsageError(
            f"colors has the type {array.dtype}; give uint8 (up to 255), uint16 (up to 65535) or floats (up to 1)"
        )
    return [(_COLORS[k], array[:, k]) for k in range(array.shape[1])]


def _check_name(name: str, taken: Set[str]) -> None:
    if name in taken:
        remedy = "leave it out" if name in _COORDINATES else "give it once"
        raise UsageError(f"the channel {name!r} is there already; {remedy}")
    if (
        not isinstance(name, str)
        or not name
        or not name.isascii()
        or any(c.isspace() or not c.isprintable() for c in name)
    ):
        raise UsageError(
            f"the channel {name!r} cannot be called so; names are of ASCII letters, digits and signs, without spaces"
        )


def check_channel(name: str, taken: Set[str], array: npt.NDArray[Any]) -> None:
    """Whether a scan can have a channel of this name and type."""
    _check_name(name, taken)
    _channel(name, array, len(array))


def _channel(name: str, values: ArrayLike, vertices: int) -> npt.NDArray[Any]:
    array = _numbers(f"the channel {name!r}", values)
    if array.shape != (vertices,):
        raise UsageError(f"the channel {name!r} has the shape {array.shape}; give one number a vertex: ({vertices},)")
    if array.dtype.name not in _TYPES:
        raise UsageError(
            f"the channel {name!r} has the type {array.dtype}, which scans do not have; "
            f"convert it to one of {', '.join(_TYPES)}"
        )
    return array


def faces_of(faces: ArrayLike, vertices: int) -> npt.NDArray[np.uint32] | None:
    """Corners of faces, checked as far as 32 bits would hide what is wrong."""
    import numpy as np

    array = _array("faces", faces)
    if array.size == 0:
        return None
    array = _numbers("faces", array)
    if array.ndim != 2 or array.shape[1] < 3:
        raise UsageError(f"faces has the shape {array.shape}; give three or more corners a face: (F, 3)")
    if array.dtype.kind not in "iu":
        raise UsageError(f"faces has the type {array.dtype}; give whole numbers, the rows of vertices")
    wrong = (array < 0) | (array >= vertices)
    if wrong.any():
        face, corner = np.argwhere(wrong)[0]
        raise UsageError(
            f"face {face} has the vertex {array[face, corner]}, but there are only {vertices}; count them from 0"
        )
    return np.ascontiguousarray(array, dtype=np.uint32)


def image_of(pixels: npt.NDArray[Any], what: str) -> _relievo.HeldImage:
    """An image of an array."""
    import numpy as np

    array = np.asarray(pixels)
    if array.ndim != 3 or array.shape[2] != 3 or array.size == 0 or array.dtype.name != "uint8":
        raise UsageError(
            f"{what} has the shape {array.shape} and the type {array.dtype}; give an image of "
            "(height, width, 3) uint8 values of red, green and blue"
        )
    return _relievo.HeldImage.of_pixels(np.ascontiguousarray(array))


def check_intrinsics(intrinsics: Sequence[float] | None) -> None:
    """A camera has four numbers, its focal lengths above 0."""
    import math

    if intrinsics is None:
        return
    if len(intrinsics) != 4 or not all(math.isfinite(v) for v in intrinsics) or min(intrinsics[:2]) <= 0:
        raise UsageError(
            f"intrinsics is {intrinsics!r}; give focal lengths above 0 and the principal point, in pixels: "
            "(fx, fy, cx, cy)"
        )
