"""What functions take."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any, TypeAlias, Union

if TYPE_CHECKING:
    import numpy.typing as npt
    import trimesh

    from ._scan import Scan

# Texts, so that neither numpy nor trimesh is imported before it is needed.
ArrayLike: TypeAlias = "npt.ArrayLike"
PathLike: TypeAlias = Union[str, "os.PathLike[str]"]
ScanLike: TypeAlias = "Scan | PathLike | tuple[ArrayLike, ArrayLike] | trimesh.Trimesh"
ImageLike: TypeAlias = "PathLike | npt.NDArray[Any]"

__all__ = ["ArrayLike", "ImageLike", "PathLike", "ScanLike"]
