"""The functions that are commands of the command line.

Made by scripts/make_python_commands.py from what `relievo schema` tells: change the script, not this file.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Literal

from . import _call
from ._reports import CompareReport, FitReport, HolesReport, InfoReport, StatsReport
from ._results import Completed, Textured, Transferred

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    from ._types import ImageLike, PathLike, ScanLike

__all__ = [
    "compare",
    "complete",
    "fit",
    "holes",
    "info",
    "render",
    "stats",
    "texture",
    "transfer",
]


def complete(
    scan: ScanLike,
    *,
    audit: float = 0.0,
    base: Literal["auto", "plane", "sphere", "cylinder", "cone", "freeform"] = "auto",
    blend: bool | None = None,
    bootstrap: bool = False,
    coherence: float = 0.3,
    color_image: PathLike | None = None,
    columns: Sequence[str] | None = None,
    error_threshold: float | None = None,
    extend: bool = False,
    form_wavelength: float | None = None,
    gap: float = 4.0,
    holes: Literal["interior", "all", "largest"] | Sequence[int] = "interior",
    intrinsics: tuple[float, float, float, float] | None = None,
    join: Literal["auto", "chart", "local"] = "auto",
    keep_outliers: bool = False,
    mask: str | None = None,
    max_area: float | None = None,
    max_edges: int | None = None,
    max_length: float | None = None,
    memory: str | int = "2GiB",
    method: Literal["coherent", "exhaustive", "paper"] = "coherent",
    no_repair: bool | Sequence[str] | None = None,
    overlap: float | None = None,
    report: PathLike | None = None,
    rotations: int | None = None,
    shape_weight: float | None = None,
    sites: int = 8192,
    spacing: Literal["nyquist", "scan"] | float | None = None,
    stray: float = 0.01,
    tile: int | None = None,
    tolerance: float = 0.1,
    window: int | None = None,
    seed: int = 0,
    threads: int | None = None,
) -> Completed:
    """Complete the missing parts of a scan.

    Parameters
    ----------
    scan : ScanLike
        Scan, path, trimesh.Trimesh, or (vertices, faces)
    audit : float, default 0.0
        Coherent method: share of the new vertices that are also searched for exhaustively, so that the JSON can say how
        good the matches are; changes nothing else
    base : Literal["auto", "plane", "sphere", "cylinder", "cone", "freeform"], default "auto"
        Base surface under the relief: auto, plane, sphere, cylinder, cone or freeform (what auto takes for holes where
        none of the others fits)
    blend : bool
        Fit copied patches to each other and to the scan where they meet in steps [default: on relief that hardly
        changes from vertex to vertex] (not by the paper's method)
    bootstrap : bool, default False
        Let completed vertices become samples
    coherence : float, default 0.3
        Coherent method: a place that continues a neighbor's source is taken unless another costs less than 1/(1 + this)
        of it, and at once where it fits better than good matches do
    color_image : PathLike
        Depth images: a colour image of the same size
    columns : Sequence[str]
        Text files without a line of names: what their columns are, with commas between, as in
        x,y,z,intensity,red,green,blue; - skips one [default: guessed]
    error_threshold : float
        Largest normalised cost (0 to 1) of a match that is accepted at first; rises by 10 % when nothing is [default:
        by the relief's spread; paper: 0.3]
    extend : bool, default False
        Continue over the rest of the base surface: of the sphere, of the cylinder's or cone's wall between the scan's
        ends, of the plane's bounding rectangle
    form_wavelength : float
        Freeform base: what is longer than this is form, what is shorter relief, in the scan's unit [default: where
        heights depend on it least]
    gap : float, default 4.0
        Points without faces: gaps wider than this many times the points' own distance stay open
    holes : Literal["interior", "all", "largest"] | Sequence[int], default "interior"
        What to fill: interior (gaps, not outer rims), all (rims too, where a base surface closes), largest, or numbers
        from ``relievo.holes``, as in 3,7
    intrinsics : tuple[float, float, float, float]
        Depth images: the camera's focal lengths and principal point in pixels
    join : Literal["auto", "chart", "local"], default "auto"
        Points without faces: how to join them, in the chart of the base surface that fits, or each with those around it
        [default: in the chart if one fits]
    keep_outliers : bool, default False
        Points without faces: join stray points, too
    mask : str
        Only holes with a painted vertex at their rim: vertices with the property NAME other than 0, or equal to VALUE,
        or of the colour RRGGBB (two hexadecimal digits each)
    max_area : float
        Leave holes open that are larger than this, in square units of the scan
    max_edges : int
        Leave holes open with more edges around them than this
    max_length : float
        Leave holes open that are longer than this around, in the scan's unit
    memory : str | int, default "2GiB"
        Most memory that tables of neighborhoods may take, as in 500M or 2GiB; beyond it they hold fewer places
    method : Literal["coherent", "exhaustive", "paper"], default "coherent"
        How to find matches
    no_repair : bool | Sequence[str]
        Leave the scan's faces as they are, or leave out some steps of their repair: degenerate, duplicates, weld,
        manifold, orient, spikes, with commas between
    overlap : float
        How far around its new vertices a tile sees everything, in the scan's unit [default: twice as far as a window]
    report : PathLike
        Write a page for the browser to this file: what was done and why, tables, plots, and the scan to turn in three
        dimensions; it needs no network
    rotations : int
        Number of rotations in which a neighborhood is tried [default: by the relief's directions; paper: 4]
    shape_weight : float
        μ in (1 − μ)·shape + μ·colour: 0 matches by shape alone, 1 by colour alone [default: by how height and colour
        vary; paper: 0.5; 0 without colours]
    sites : int, default 8192
        Coherent method: number of places, evenly spread over the scan, that are looked at for every new vertex
    spacing : Literal["nyquist", "scan"] | float
        Distance of new vertices: nyquist (the scan's short edges), scan (its median edge), or a length in the scan's
        unit [default: nyquist]
    stray : float, default 0.01
        Do not copy from pieces of surface with fewer vertices than this share of the largest piece's
    tile : int
        Complete in tiles of at most so many vertices, one after the other, for a scan that is too large for the memory
        in one piece; each tile copies from its own surroundings
    tolerance : float, default 0.1
        Pick at random among matches that cost up to this share more than the best: 0.1 is 10 %
    window : int
        Radius of a neighborhood, in edges; the coherent and the exhaustive method see half as densely from 4/5 of it to
        8/5 [default: by the relief's correlation length; paper: 5]
    seed : int, default 0
        Seed of all random choices: the same seed gives the same bytes
    threads : int
        Number of threads, by default one a core; the result does not depend on it

    Returns
    -------
    Completed
        ``.scan`` is the completed scan: first all that was there, bit for bit and in its order, then what is new,
        marked by the channel ``completed`` (1). ``.partly`` is true if some of the chosen gaps stayed open;
        ``.report["skipped"]`` says why.

    Raises
    ------
    RelievoError
        WorkError if no hole could be filled; UsageError if options cannot be meant so; ReadError if a file cannot be
        read.

    Examples
    --------
    >>> done = relievo.complete("data/scans/bricks-hole.ply", holes="largest")
    >>> done.report["counts"]["completed_vertices"], done.partly
    (142, False)
    """
    return _call.completed(
        "complete",
        {"scan": scan},
        {
            "audit": audit,
            "base": base,
            "blend": blend,
            "bootstrap": bootstrap,
            "coherence": coherence,
            "color_image": color_image,
            "columns": columns,
            "error_threshold": error_threshold,
            "extend": extend,
            "form_wavelength": form_wavelength,
            "gap": gap,
            "holes": holes,
            "intrinsics": intrinsics,
            "join": join,
            "keep_outliers": keep_outliers,
            "mask": mask,
            "max_area": max_area,
            "max_edges": max_edges,
            "max_length": max_length,
            "memory": memory,
            "method": method,
            "no_repair": no_repair,
            "overlap": overlap,
            "report": report,
            "rotations": rotations,
            "shape_weight": shape_weight,
            "sites": sites,
            "spacing": spacing,
            "stray": stray,
            "tile": tile,
            "tolerance": tolerance,
            "window": window,
        },
        seed,
        threads,
    )


def fit(
    scan: ScanLike,
    *,
    base: Literal["auto", "plane", "sphere", "cylinder", "cone"] = "auto",
    color_image: PathLike | None = None,
    columns: Sequence[str] | None = None,
    gap: float = 4.0,
    intrinsics: tuple[float, float, float, float] | None = None,
    join: Literal["auto", "chart", "local"] = "auto",
    keep_outliers: bool = False,
    no_repair: bool | Sequence[str] | None = None,
    seed: int = 0,
    threads: int | None = None,
) -> FitReport:
    """Fit a base surface: parameters, residuals, how the other kinds compare.

    Parameters
    ----------
    scan : ScanLike
        Scan, path, trimesh.Trimesh, or (vertices, faces)
    base : Literal["auto", "plane", "sphere", "cylinder", "cone"], default "auto"
        Base surface: auto, plane, sphere, cylinder or cone
    color_image : PathLike
        Depth images: a colour image of the same size
    columns : Sequence[str]
        Text files without a line of names: what their columns are, with commas between, as in
        x,y,z,intensity,red,green,blue; - skips one [default: guessed]
    gap : float, default 4.0
        Points without faces: gaps wider than this many times the points' own distance stay open
    intrinsics : tuple[float, float, float, float]
        Depth images: the camera's focal lengths and principal point in pixels
    join : Literal["auto", "chart", "local"], default "auto"
        Points without faces: how to join them, in the chart of the base surface that fits, or each with those around it
        [default: in the chart if one fits]
    keep_outliers : bool, default False
        Points without faces: join stray points, too
    no_repair : bool | Sequence[str]
        Leave the scan's faces as they are, or leave out some steps of their repair: degenerate, duplicates, weld,
        manifold, orient, spikes, with commas between
    seed : int, default 0
        Seed of all random choices: the same seed gives the same bytes
    threads : int
        Number of threads, by default one a core; the result does not depend on it

    Returns
    -------
    FitReport
        The base surface (``["base"]``), how it fits, and how the other kinds compare (``["ranking"]``).

    Raises
    ------
    RelievoError
        WorkError if there is nothing to fit to; UsageError if options cannot be meant so; ReadError if a file cannot be
        read.

    Examples
    --------
    >>> relievo.fit("data/scans/golf-ball-half.ply")["base"]["kind"]
    'sphere'
    """
    told: FitReport = _call.report(
        "fit",
        {"scan": scan},
        {
            "base": base,
            "color_image": color_image,
            "columns": columns,
            "gap": gap,
            "intrinsics": intrinsics,
            "join": join,
            "keep_outliers": keep_outliers,
            "no_repair": no_repair,
        },
        seed,
        threads,
    )
    return told


def holes(
    scan: ScanLike,
    *,
    color_image: PathLike | None = None,
    columns: Sequence[str] | None = None,
    gap: float = 4.0,
    intrinsics: tuple[float, float, float, float] | None = None,
    join: Literal["auto", "chart", "local"] = "auto",
    keep_outliers: bool = False,
    no_repair: bool | Sequence[str] | None = None,
    seed: int = 0,
    threads: int | None = None,
) -> HolesReport:
    """List every boundary loop: id, edges, length, area estimate, hole or outer rim.

    Parameters
    ----------
    scan : ScanLike
        Scan, path, trimesh.Trimesh, or (vertices, faces)
    color_image : PathLike
        Depth images: a colour image of the same size
    columns : Sequence[str]
        Text files without a line of names: what their columns are, with commas between, as in
        x,y,z,intensity,red,green,blue; - skips one [default: guessed]
    gap : float, default 4.0
        Points without faces: gaps wider than this many times the points' own distance stay open
    intrinsics : tuple[float, float, float, float]
        Depth images: the camera's focal lengths and principal point in pixels
    join : Literal["auto", "chart", "local"], default "auto"
        Points without faces: how to join them, in the chart of the base surface that fits, or each with those around it
        [default: in the chart if one fits]
    keep_outliers : bool, default False
        Points without faces: join stray points, too
    no_repair : bool | Sequence[str]
        Leave the scan's faces as they are, or leave out some steps of their repair: degenerate, duplicates, weld,
        manifold, orient, spikes, with commas between
    seed : int, default 0
        Seed of all random choices: the same seed gives the same bytes
    threads : int
        Number of threads, by default one a core; the result does not depend on it

    Returns
    -------
    HolesReport
        Every boundary loop (``["loops"]``); the ``id`` of each is what ``complete(holes=[...])`` takes.

    Raises
    ------
    RelievoError
        WorkError if the scan has no surface; UsageError if options cannot be meant so; ReadError if a file cannot be
        read.

    Examples
    --------
    >>> [(loop["id"], loop["kind"]) for loop in relievo.holes("data/scans/bricks-hole.ply")["loops"]]
    [(0, 'rim'), (1, 'hole')]
    """
    told: HolesReport = _call.report(
        "holes",
        {"scan": scan},
        {
            "color_image": color_image,
            "columns": columns,
            "gap": gap,
            "intrinsics": intrinsics,
            "join": join,
            "keep_outliers": keep_outliers,
            "no_repair": no_repair,
        },
        seed,
        threads,
    )
    return told


def info(
    scan: ScanLike,
    *,
    color_image: PathLike | None = None,
    columns: Sequence[str] | None = None,
    intrinsics: tuple[float, float, float, float] | None = None,
    seed: int = 0,
    threads: int | None = None,
) -> InfoReport:
    """Tell what is in a file: vertices, faces, properties, extent, pieces, holes, what would be repaired.

    Parameters
    ----------
    scan : ScanLike
        Scan, path, trimesh.Trimesh, or (vertices, faces)
    color_image : PathLike
        Depth images: a colour image of the same size
    columns : Sequence[str]
        Text files without a line of names: what their columns are, with commas between, as in
        x,y,z,intensity,red,green,blue; - skips one [default: guessed]
    intrinsics : tuple[float, float, float, float]
        Depth images: the camera's focal lengths and principal point in pixels
    seed : int, default 0
        Seed of all random choices: the same seed gives the same bytes
    threads : int
        Number of threads, by default one a core; the result does not depend on it

    Returns
    -------
    InfoReport
        What is in the scan: counts, channels, extent, pieces, holes, what would be repaired.

    Raises
    ------
    RelievoError
        ReadError if it cannot be read; UsageError if options cannot be meant so; ReadError if a file cannot be read.
    """
    told: InfoReport = _call.report(
        "info",
        {"scan": scan},
        {
            "color_image": color_image,
            "columns": columns,
            "intrinsics": intrinsics,
        },
        seed,
        threads,
    )
    return told


def stats(
    scan: ScanLike,
    *,
    base: Literal["auto", "plane", "sphere", "cylinder", "cone", "freeform"] = "auto",
    color_image: PathLike | None = None,
    columns: Sequence[str] | None = None,
    csv: PathLike | None = None,
    form_wavelength: float | None = None,
    gap: float = 4.0,
    intrinsics: tuple[float, float, float, float] | None = None,
    join: Literal["auto", "chart", "local"] = "auto",
    keep_outliers: bool = False,
    l_filter: float | None = None,
    no_repair: bool | Sequence[str] | None = None,
    pieces: int = 128,
    report: PathLike | None = None,
    s_filter: float | None = None,
    whole: bool = False,
    seed: int = 0,
    threads: int | None = None,
) -> StatsReport:
    """Compare the original part of a completed scan with the completed part, or tell the areal parameters of a height
        map (``step``).

    Parameters
    ----------
    scan : ScanLike
        Scan, path, trimesh.Trimesh, or (vertices, faces)
    base : Literal["auto", "plane", "sphere", "cylinder", "cone", "freeform"], default "auto"
        Base surface under the relief: auto, plane, sphere, cylinder, cone or freeform [default: as noted by complete,
        else what fits, else freeform]
    color_image : PathLike
        Depth images: a colour image of the same size
    columns : Sequence[str]
        Text files without a line of names: what their columns are, with commas between, as in
        x,y,z,intensity,red,green,blue; - skips one [default: guessed]
    csv : PathLike
        Write the table as CSV to this file
    form_wavelength : float
        Freeform base: what is longer than this is form, what is shorter relief, in the scan's unit [default: where
        heights depend on it least]
    gap : float, default 4.0
        Points without faces: gaps wider than this many times the points' own distance stay open
    intrinsics : tuple[float, float, float, float]
        Depth images: the camera's focal lengths and principal point in pixels
    join : Literal["auto", "chart", "local"], default "auto"
        Points without faces: how to join them, in the chart of the base surface that fits, or each with those around it
        [default: in the chart if one fits]
    keep_outliers : bool, default False
        Points without faces: join stray points, too
    l_filter : float
        L-filter: take waves longer than this off the heights
    no_repair : bool | Sequence[str]
        Leave the scan's faces as they are, or leave out some steps of their repair: degenerate, duplicates, weld,
        manifold, orient, spikes, with commas between
    pieces : int, default 128
        Number of pieces of the original that natural variation is taken from, at least 60; 0 for no scores
    report : PathLike
        Write a page for the browser to this file: what was done and why, tables, plots, and the scan to turn in three
        dimensions; it needs no network
    s_filter : float
        S-filter: take waves shorter than this off the heights (a half of it at this length)
    whole : bool, default False
        Figures of the scan as a whole, completed or not, without comparing its parts
    seed : int, default 0
        Seed of all random choices: the same seed gives the same bytes
    threads : int
        Number of threads, by default one a core; the result does not depend on it

    Returns
    -------
    StatsReport
        The figures of both parts, how far they differ in units of natural variation, and a verdict in words.

    Raises
    ------
    RelievoError
        WorkError if the scan has no completed part; UsageError if options cannot be meant so; ReadError if a file
        cannot be read.
    """
    told: StatsReport = _call.report(
        "stats",
        {"scan": scan},
        {
            "base": base,
            "color_image": color_image,
            "columns": columns,
            "csv": csv,
            "form_wavelength": form_wavelength,
            "gap": gap,
            "intrinsics": intrinsics,
            "join": join,
            "keep_outliers": keep_outliers,
            "l_filter": l_filter,
            "no_repair": no_repair,
            "pieces": pieces,
            "report": report,
            "s_filter": s_filter,
            "whole": whole,
        },
        seed,
        threads,
    )
    return told


def compare(
    scan: ScanLike,
    other: ScanLike | None = None,
    *,
    base: Literal["auto", "plane", "sphere", "cylinder", "cone", "freeform"] = "auto",
    color_image: PathLike | None = None,
    columns: Sequence[str] | None = None,
    csv: PathLike | None = None,
    form_wavelength: float | None = None,
    gap: float = 4.0,
    intrinsics: tuple[float, float, float, float] | None = None,
    join: Literal["auto", "chart", "local"] = "auto",
    keep_outliers: bool = False,
    l_filter: float | None = None,
    no_repair: bool | Sequence[str] | None = None,
    other_part: str | None = None,
    part: str | None = None,
    pieces: int = 128,
    report: PathLike | None = None,
    s_filter: float | None = None,
    seed: int = 0,
    threads: int | None = None,
) -> CompareReport:
    """Compare two scans, or two parts of one, in figures and in units of natural variation.

    Parameters
    ----------
    scan : ScanLike
        Scan, path, trimesh.Trimesh, or (vertices, faces)
    other : ScanLike | None
        Scan, path, trimesh.Trimesh, or (vertices, faces); without it two parts of one scan are compared
    base : Literal["auto", "plane", "sphere", "cylinder", "cone", "freeform"], default "auto"
        Base surface under the relief: auto, plane, sphere, cylinder, cone or freeform [default: as noted by complete,
        else what fits, else freeform]
    color_image : PathLike
        Depth images: a colour image of the same size
    columns : Sequence[str]
        Text files without a line of names: what their columns are, with commas between, as in
        x,y,z,intensity,red,green,blue; - skips one [default: guessed]
    csv : PathLike
        Write the table as CSV to this file
    form_wavelength : float
        Freeform base: what is longer than this is form, what is shorter relief, in the scan's unit [default: where
        heights depend on it least]
    gap : float, default 4.0
        Points without faces: gaps wider than this many times the points' own distance stay open
    intrinsics : tuple[float, float, float, float]
        Depth images: the camera's focal lengths and principal point in pixels
    join : Literal["auto", "chart", "local"], default "auto"
        Points without faces: how to join them, in the chart of the base surface that fits, or each with those around it
        [default: in the chart if one fits]
    keep_outliers : bool, default False
        Points without faces: join stray points, too
    l_filter : float
        L-filter: take waves longer than this off the heights
    no_repair : bool | Sequence[str]
        Leave the scan's faces as they are, or leave out some steps of their repair: degenerate, duplicates, weld,
        manifold, orient, spikes, with commas between
    other_part : str
        The same of the other scan
    part : str
        Of the first scan only vertices with the property NAME other than 0, or equal to VALUE, or of the colour RRGGBB
    pieces : int, default 128
        Number of pieces of the original that natural variation is taken from, at least 60; 0 for no scores
    report : PathLike
        Write a page for the browser to this file: what was done and why, tables, plots, and the scan to turn in three
        dimensions; it needs no network
    s_filter : float
        S-filter: take waves shorter than this off the heights (a half of it at this length)
    seed : int, default 0
        Seed of all random choices: the same seed gives the same bytes
    threads : int
        Number of threads, by default one a core; the result does not depend on it

    Returns
    -------
    CompareReport
        The figures of both, ``["a"]`` and ``["b"]``, how far they differ in units of natural variation, and a verdict
        in words.

    Raises
    ------
    RelievoError
        WorkError if one of them has too little surface; UsageError if options cannot be meant so; ReadError if a file
        cannot be read.
    """
    told: CompareReport = _call.report(
        "compare",
        {"scan": scan, "other": other},
        {
            "base": base,
            "color_image": color_image,
            "columns": columns,
            "csv": csv,
            "form_wavelength": form_wavelength,
            "gap": gap,
            "intrinsics": intrinsics,
            "join": join,
            "keep_outliers": keep_outliers,
            "l_filter": l_filter,
            "no_repair": no_repair,
            "other_part": other_part,
            "part": part,
            "pieces": pieces,
            "report": report,
            "s_filter": s_filter,
        },
        seed,
        threads,
    )
    return told


def texture(
    mesh: ScanLike,
    exemplar: ScanLike | ImageLike,
    *,
    output: PathLike | None = None,
    color_image: PathLike | None = None,
    columns: Sequence[str] | None = None,
    displace: float | None = None,
    gap: float = 4.0,
    image_size: int | None = None,
    intrinsics: tuple[float, float, float, float] | None = None,
    join: Literal["auto", "chart", "local"] = "auto",
    keep_mesh: bool = False,
    keep_outliers: bool = False,
    levels: int | None = None,
    method: Literal["coherent", "wei-levoy"] = "coherent",
    no_repair: bool | Sequence[str] | None = None,
    orientation: Literal["relax", "random", "x", "y", "z"] | tuple[float, float, float] | PathLike = "relax",
    overwrite: bool = False,
    report: PathLike | None = None,
    search: Literal["tree", "exhaustive"] = "tree",
    symmetry: int = 1,
    texel: float | None = None,
    vertices: int | None = None,
    seed: int = 0,
    threads: int | None = None,
) -> Textured:
    """Put the texture of a sample, an image or a scan, all over a mesh: in colour, or as relief.

    Parameters
    ----------
    mesh : ScanLike
        Scan, path, trimesh.Trimesh, or (vertices, faces)
    exemplar : ScanLike | ImageLike
        the sample of texture: an image (path, or (height, width, 3) array of uint8), or a scan whose relief and colours
        are taken
    output : PathLike | None
        the file to write the mesh to as well; with ``keep_mesh`` with a texture image, if the mesh has texture
        coordinates
    color_image : PathLike
        Depth images: a colour image of the same size
    columns : Sequence[str]
        Text files without a line of names: what their columns are, with commas between, as in
        x,y,z,intensity,red,green,blue; - skips one [default: guessed]
    displace : float
        Move vertices along their normals: SCALE times the sample's relief (1 keeps its proportions) or, of an image,
        SCALE (in the scan's unit) from black to white around the mean [default: 1 for a scan with relief, else not]
    gap : float, default 4.0
        Points without faces: gaps wider than this many times the points' own distance stay open
    image_size : int
        Largest side of the texture image, in pixels [default: by the texel, up to 8192]
    intrinsics : tuple[float, float, float, float]
        Depth images: the camera's focal lengths and principal point in pixels
    join : Literal["auto", "chart", "local"], default "auto"
        Points without faces: how to join them, in the chart of the base surface that fits, or each with those around it
        [default: in the chart if one fits]
    keep_mesh : bool, default False
        Put the texture on the mesh as it is: colours at its vertices and, if it has texture coordinates and ``output``
        is .ply, .obj or .glb, a texture image
    keep_outliers : bool, default False
        Points without faces: join stray points, too
    levels : int
        Number of resolutions [default: as many as leave the coarsest sample 8 texels wide; wei-levoy: 4]
    method : Literal["coherent", "wei-levoy"], default "coherent"
        How the texture grows
    no_repair : bool | Sequence[str]
        Leave the scan's faces as they are, or leave out some steps of their repair: degenerate, duplicates, weld,
        manifold, orient, spikes, with commas between
    orientation : Literal["relax", "random", "x", "y", "z"] | tuple[float, float, float] | PathLike, default "relax"
        Where the sample's first axis (an image's rows) points: relax (as parallel as the surface allows), random, x, y,
        z, DX,DY,DZ, or a file with points x, y, z and directions tx, ty, tz, such as a textured PLY
    overwrite : bool, default False
        Replace the file if there is one of this name
    report : PathLike
        Write a page for the browser to this file: what was done and why, tables, plots, and the scan to turn in three
        dimensions; it needs no network
    search : Literal["tree", "exhaustive"], default "tree"
        How ``method`` wei-levoy finds the nearest neighborhood
    symmetry : int, default 1
        The texture looks the same after a turn by a whole share of this: 1, 2 for lines, 4 for grids, …
    texel : float
        Length of a texel of the sample on the mesh, in the scan's unit
    vertices : int
        Number of vertices of the textured mesh; each takes a texel of the sample [default: as many as the mesh has, at
        least 24576; for a scan as sample, so many that its texture keeps its size]
    seed : int, default 0
        Seed of all random choices: the same seed gives the same bytes
    threads : int
        Number of threads, by default one a core; the result does not depend on it

    Returns
    -------
    Textured
        ``.scan`` is the textured mesh.

    Raises
    ------
    RelievoError
        WorkError if the texture cannot be put on this mesh; UsageError if options cannot be meant so; ReadError if a
        file cannot be read.
    """
    return _call.textured(
        "texture",
        {"scan": mesh, "exemplar": exemplar, "output": output},
        {
            "color_image": color_image,
            "columns": columns,
            "displace": displace,
            "gap": gap,
            "image_size": image_size,
            "intrinsics": intrinsics,
            "join": join,
            "keep_mesh": keep_mesh,
            "keep_outliers": keep_outliers,
            "levels": levels,
            "method": method,
            "no_repair": no_repair,
            "orientation": orientation,
            "overwrite": overwrite,
            "report": report,
            "search": search,
            "symmetry": symmetry,
            "texel": texel,
            "vertices": vertices,
        },
        seed,
        threads,
    )


def transfer(
    *,
    target: ScanLike,
    source: ScanLike | None = None,
    output: PathLike | None = None,
    audit: int = 0,
    channel: Literal["color", "height", "both"] = "color",
    coherence: float = 0.3,
    color_image: PathLike | None = None,
    columns: Sequence[str] | None = None,
    correspondences: PathLike | None = None,
    displace: float | None = None,
    final: Literal["nearest", "vote"] = "nearest",
    form_wavelength: float | None = None,
    gap: float = 4.0,
    image_size: int | None = None,
    init: PathLike | None = None,
    intrinsics: tuple[float, float, float, float] | None = None,
    join: Literal["auto", "chart", "local"] = "auto",
    keep_mesh: bool = False,
    keep_outliers: bool = False,
    mask: str | None = None,
    no_repair: bool | Sequence[str] | None = None,
    overuse: float = 0.02,
    overwrite: bool = False,
    report: PathLike | None = None,
    rotations: Literal["all", "search"] = "all",
    rounds: int = 5,
    scale: float = 1.0,
    shape: Literal["heat-kernel", "position", "none"] = "heat-kernel",
    shape_weight: float = 0.2,
    source_up: Literal["x", "y", "z", "none"] | tuple[float, float, float] | None = None,
    up: Literal["x", "y", "z", "none"] | tuple[float, float, float] = "y",
    vertices: int | None = None,
    seed: int = 0,
    threads: int | None = None,
) -> Transferred:
    """Copy colours or relief from one mesh onto another, following its shape, or from a part of a mesh onto the rest.

    Parameters
    ----------
    target : ScanLike
        where to: Scan, path, trimesh.Trimesh, or (vertices, faces)
    source : ScanLike | None
        where from: Scan, path, trimesh.Trimesh, or (vertices, faces); or ``mask``
    output : PathLike | None
        the file to write the mesh to as well; with ``keep_mesh`` with a texture image, if the mesh has texture
        coordinates
    audit : int, default 0
        Compare the matches of so many vertices with the best of all that there are; the JSON tells how they do
    channel : Literal["color", "height", "both"], default "color"
        What is copied
    coherence : float, default 0.3
        Share of its cost that a match is spared if it continues that of a neighbor: more keeps larger pieces of the
        source together
    color_image : PathLike
        Depth images: a colour image of the same size
    columns : Sequence[str]
        Text files without a line of names: what their columns are, with commas between, as in
        x,y,z,intensity,red,green,blue; - skips one [default: guessed]
    correspondences : PathLike
        Places that belong together: JSON, a list of pairs [SOURCE, TARGET] of vertices (from 0) or points [x, y, z], or
        {"pairs": [{"source": …, "target": … or a list}, …]}; what is near them is alike
    displace : float
        Move vertices along their normals by SCALE times the source's relief (1 keeps its proportions) [default: 1]
    final : Literal["nearest", "vote"], default "nearest"
        What the target gets in the end
    form_wavelength : float
        Relief: what is longer than this is form, what is shorter relief, in the source's unit [default: where heights
        depend on it least]
    gap : float, default 4.0
        Points without faces: gaps wider than this many times the points' own distance stay open
    image_size : int
        Largest side of the texture image that targets with texture coordinates get, in pixels [default: by the vertices
        worked on, up to 8192]
    init : PathLike
        Start from a map: the source's vertex for each of the target's, as text with one number a line (from 0; -1 or
        nan for none), as a JSON list, or as a mesh with the vertex property source, such as what this command writes
    intrinsics : tuple[float, float, float, float]
        Depth images: the camera's focal lengths and principal point in pixels
    join : Literal["auto", "chart", "local"], default "auto"
        Points without faces: how to join them, in the chart of the base surface that fits, or each with those around it
        [default: in the chart if one fits]
    keep_mesh : bool, default False
        Put no vertices on the target's edges: what comes out has its own vertices only
    keep_outliers : bool, default False
        Points without faces: join stray points, too
    mask : str
        Only one mesh: spread what is painted over the rest; painted is where this vertex property is not 0, or has the
        value of NAME=VALUE, or where the colour is not exactly #RRGGBB
    no_repair : bool | Sequence[str]
        Leave the scan's faces as they are, or leave out some steps of their repair: degenerate, duplicates, weld,
        manifold, orient, spikes, with commas between
    overuse : float, default 0.02
        Penalty, in units of the cost, of a vertex of the source that is used twice as often as others: more spreads all
        of the source over the target where its shape does not tell
    overwrite : bool, default False
        Replace the file if there is one of this name
    report : PathLike
        Write a page for the browser to this file: what was done and why, tables, plots, and the scan to turn in three
        dimensions; it needs no network
    rotations : Literal["all", "search"], default "all"
        How rotations are compared
    rounds : int, default 5
        Rounds of search and votes on each level
    scale : float, default 1.0
        Size of the texture on the target, where 1 keeps its size against the mesh
    shape : Literal["heat-kernel", "position", "none"], default "heat-kernel"
        What tells which parts of the meshes are alike
    shape_weight : float, default 0.2
        How much shape counts against colours or relief, from 0 to 1
    source_up : Literal["x", "y", "z", "none"] | tuple[float, float, float]
        What is up on the source [default: as ``up``]
    up : Literal["x", "y", "z", "none"] | tuple[float, float, float], default "y"
        What is up on both meshes: x, y, z, none, or a direction
    vertices : int
        Work on at least so many vertices of the target; those that it lacks are put on its edges [default: as many as
        the source has, up to 65536]
    seed : int, default 0
        Seed of all random choices: the same seed gives the same bytes
    threads : int
        Number of threads, by default one a core; the result does not depend on it

    Returns
    -------
    Transferred
        ``.scan`` is the target with what was transferred.

    Raises
    ------
    RelievoError
        WorkError if nothing can be transferred; UsageError if options cannot be meant so; ReadError if a file cannot be
        read.
    """
    return _call.transferred(
        "transfer",
        {"target": target, "source": source, "output": output},
        {
            "audit": audit,
            "channel": channel,
            "coherence": coherence,
            "color_image": color_image,
            "columns": columns,
            "correspondences": correspondences,
            "displace": displace,
            "final": final,
            "form_wavelength": form_wavelength,
            "gap": gap,
            "image_size": image_size,
            "init": init,
            "intrinsics": intrinsics,
            "join": join,
            "keep_mesh": keep_mesh,
            "keep_outliers": keep_outliers,
            "mask": mask,
            "no_repair": no_repair,
            "overuse": overuse,
            "overwrite": overwrite,
            "report": report,
            "rotations": rotations,
            "rounds": rounds,
            "scale": scale,
            "shape": shape,
            "shape_weight": shape_weight,
            "source_up": source_up,
            "up": up,
            "vertices": vertices,
        },
        seed,
        threads,
    )


def render(
    scan: ScanLike,
    path: PathLike | None = None,
    *,
    background: str = "white",
    before: bool = False,
    channel: str | None = None,
    color_image: PathLike | None = None,
    columns: Sequence[str] | None = None,
    gap: float = 4.0,
    intrinsics: tuple[float, float, float, float] | None = None,
    join: Literal["auto", "chart", "local"] = "auto",
    keep_outliers: bool = False,
    look_at: Literal["all", "completed"] = "all",
    no_legend: bool = False,
    no_repair: bool | Sequence[str] | None = None,
    overwrite: bool = False,
    projection: Literal["perspective", "orthographic"] = "perspective",
    range: tuple[float, float] | None = None,
    size: str | tuple[int, int] = "1600x1200",
    up: Literal["auto", "x", "y", "z"] = "auto",
    view: Literal["auto", "front", "back", "left", "right", "top", "bottom", "iso"] | tuple[float, float] = "auto",
    wireframe: bool = False,
    zoom: float = 1.0,
    seed: int = 0,
    threads: int | None = None,
) -> npt.NDArray[np.uint8]:
    """Draw a scan or one of its channels as a PNG picture, without a display.

    Parameters
    ----------
    scan : ScanLike
        Scan, path, trimesh.Trimesh, or (vertices, faces)
    path : PathLike | None
        the PNG picture to write as well
    background : str, default "white"
        white, black, transparent or #RRGGBB
    before : bool, default False
        Leave out what was completed; camera and colours stay as they are with it
    channel : str
        What the colours show: color, shape, height (over the base surface), completed, cost, source (where completed
        vertices were copied from), or the name of a vertex property [default: color if the scan has any, else shape]
    color_image : PathLike
        Depth images: a colour image of the same size
    columns : Sequence[str]
        Text files without a line of names: what their columns are, with commas between, as in
        x,y,z,intensity,red,green,blue; - skips one [default: guessed]
    gap : float, default 4.0
        Points without faces: gaps wider than this many times the points' own distance stay open
    intrinsics : tuple[float, float, float, float]
        Depth images: the camera's focal lengths and principal point in pixels
    join : Literal["auto", "chart", "local"], default "auto"
        Points without faces: how to join them, in the chart of the base surface that fits, or each with those around it
        [default: in the chart if one fits]
    keep_outliers : bool, default False
        Points without faces: join stray points, too
    look_at : Literal["all", "completed"], default "all"
        What fills the picture: all, or what was completed and what is around it
    no_legend : bool, default False
        Draw no color bar
    no_repair : bool | Sequence[str]
        Leave the scan's faces as they are, or leave out some steps of their repair: degenerate, duplicates, weld,
        manifold, orient, spikes, with commas between
    overwrite : bool, default False
        Replace the file if there is one of this name
    projection : Literal["perspective", "orthographic"], default "perspective"
        How depth is drawn: what is nearer is larger, or one length everywhere
    range : tuple[float, float]
        Values at the two ends of the color bar [default: the 2 % and 98 % quantiles, around 0 for heights]
    size : str | tuple[int, int], default "1600x1200"
        Width and height in pixels
    up : Literal["auto", "x", "y", "z"], default "auto"
        Axis that points up [default: z if the scan is longest along it, else y]
    view : Literal["auto", "front", "back", "left", "right", "top", "bottom", "iso"] | tuple[float, float], default "auto"
        From where: front, back, left, right, top, bottom, iso, or angles in degrees, from the front to the object's
        right and upwards; auto: from the side that the faces of a surface look to, others from where the completed part
        is seen, or iso
    wireframe : bool, default False
        Draw the edges of the triangles
    zoom : float, default 1.0
        Enlarge the middle of the picture
    seed : int, default 0
        Seed of all random choices: the same seed gives the same bytes
    threads : int
        Number of threads, by default one a core; the result does not depend on it

    Returns
    -------
    npt.NDArray[np.uint8]
        The picture: (height, width, 3) red, green and blue, rows from the top, read-only; (height, width, 4) with
        opacity if the background is transparent.

    Raises
    ------
    RelievoError
        WriteError if the picture cannot be written; UsageError if options cannot be meant so; ReadError if a file
        cannot be read.
    """
    return _call.picture(
        "render",
        {"scan": scan, "output": path},
        {
            "background": background,
            "before": before,
            "channel": channel,
            "color_image": color_image,
            "columns": columns,
            "gap": gap,
            "intrinsics": intrinsics,
            "join": join,
            "keep_outliers": keep_outliers,
            "look_at": look_at,
            "no_legend": no_legend,
            "no_repair": no_repair,
            "overwrite": overwrite,
            "projection": projection,
            "range": range,
            "size": size,
            "up": up,
            "view": view,
            "wireframe": wireframe,
            "zoom": zoom,
        },
        seed,
        threads,
    )
