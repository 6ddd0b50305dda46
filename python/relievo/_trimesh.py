"""Scans from and to ``trimesh.Trimesh``, without importing it before it is needed."""

from __future__ import annotations

import logging
import sys
from typing import TYPE_CHECKING, Any, TypeGuard

from . import _arrays
from ._errors import UsageError

if TYPE_CHECKING:
    import numpy.typing as npt
    import trimesh

    from ._scan import Scan

_logger = logging.getLogger("relievo")


def is_trimesh(given: object) -> TypeGuard[trimesh.Trimesh]:
    """Whether something is a mesh of trimesh; if so, somebody has imported it."""
    module = sys.modules.get("trimesh")
    return module is not None and isinstance(given, module.Trimesh)


def scan_of(mesh: trimesh.Trimesh) -> Scan:
    """See :meth:`relievo.Scan.from_trimesh`."""
    from ._scan import Scan

    if not is_trimesh(mesh):
        raise UsageError(remedy(mesh))
    colors = _colors(mesh)
    taken = {"x", "y", "z"} if colors is None else {"x", "y", "z", "red", "green", "blue", "alpha"}
    return Scan(mesh.vertices, mesh.faces, colors, _channels(mesh, taken))


def remedy(given: object) -> str:
    """What to do with what is no mesh."""
    remedies = {
        "Scene": "give one of its meshes, or all of them joined: scene.to_mesh()",
        "PointCloud": "give relievo.Scan(cloud.vertices)",
    }
    name = type(given).__name__
    return f"a {name} is no trimesh.Trimesh; {remedies.get(name, 'give one')}"


def _colors(mesh: trimesh.Trimesh) -> npt.NDArray[Any] | None:
    # Its classes differ between versions of trimesh.
    visual: Any = mesh.visual
    if visual.kind == "vertex":
        return _opaque(visual.vertex_colors)
    if visual.kind == "face":
        _logger.warning("the trimesh has colours of faces, which are lost; give colours of vertices to keep them")
    if visual.kind == "texture":
        colors = getattr(visual.to_color(), "vertex_colors", None)
        if colors is not None and len(colors) == len(mesh.vertices):
            _logger.warning(
                "of the trimesh's texture only the colours at the vertices are kept; "
                "give the path of its file to functions that read textures"
            )
            return _opaque(colors)
        _logger.warning("the trimesh's texture has no colours for its vertices and is lost")
    return None


def _opaque(colors: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Without the opacity, where it is full."""
    import numpy as np

    array = np.asarray(colors)
    return array[:, :3] if array.shape[1] == 4 and bool((array[:, 3] == 255).all()) else array


def _channels(mesh: trimesh.Trimesh, taken: set[str]) -> dict[str, npt.NDArray[Any]]:
    """The attributes of vertices that a scan can hold, under names that are not taken."""
    import numpy as np

    kept: dict[str, npt.NDArray[Any]] = {}
    for name, values in mesh.vertex_attributes.items():
        array = np.asarray(values)
        if array.shape != (len(mesh.vertices),) or array.dtype.kind not in "biuf":
            _logger.warning("the trimesh's attribute %r is no number for each vertex and is lost", name)
            continue
        if array.dtype.itemsize == 8 and array.dtype.kind in "iu":
            array = array.astype("float64")
        elif array.dtype == np.float16:
            array = array.astype("float32")
        try:
            _arrays.check_channel(name, taken | kept.keys(), array)
        except UsageError as error:
            _logger.warning("the trimesh's attribute %r is lost: %s", name, error)
            continue
        kept[name] = array
    return kept


def mesh_of(scan: Scan) -> trimesh.Trimesh:
    """See :meth:`relievo.Scan.to_trimesh`."""
    try:
        import trimesh
    except ImportError:
        raise UsageError("trimesh is not installed; install it by `pip install relievo[trimesh]`") from None
    colors = scan.colors
    names = {"x", "y", "z", "red", "green", "blue"}
    attributes: Any = {name: values.copy() for name, values in scan.channels.items() if name not in names}
    return trimesh.Trimesh(
        scan.vertices.copy(),
        scan.faces.astype("int64"),
        vertex_colors=None if colors is None else colors.copy(),
        vertex_attributes=attributes,
        process=False,
    )
