"""What functions tell: the JSON objects of the command line (``--json``), their main members typed.

The member ``pipeline`` is there for pipelines only. Members that are not listed here are there all the same. Lengths are
in the scan's unit, areas in its square.
"""

from __future__ import annotations

from typing import Any, Literal, TypedDict


class Base(TypedDict, total=False):
    """A base surface: its kind and parameters (plane: ``point``, ``normal``; sphere: ``center``, ``radius``; cylinder:
    ``point``, ``axis``, ``radius``; cone: ``apex``, ``axis``, ``half_angle`` in radians)."""

    kind: Literal["plane", "sphere", "cylinder", "cone"]
    point: list[float]
    normal: list[float]
    center: list[float]
    apex: list[float]
    axis: list[float]
    radius: float
    half_angle: float


class Candidate(TypedDict):
    """How one kind of base surface fits."""

    base: Base
    rms: float
    scale: float
    criterion: float
    degenerate: str | None
    reason: str


class Report(TypedDict, total=False):
    """What all of them have."""

    command: str
    version: str
    status: Literal["done", "partly"]
    #: The scan's path, if it was given as one.
    input: str
    repair: dict[str, int]
    cloud: dict[str, Any]


class FitReport(Report, total=False):
    """A fitted base surface; the kinds from best to worst in ``ranking``."""

    base: Base
    fits: bool
    rms: float
    inlier_rms: float
    inlier_share: float
    max_residual: float
    mean_height: float
    diagonal: float
    iterations: int
    reason: str
    vertices: int
    ranking: list[Candidate]


class Loop(TypedDict, total=False):
    """A boundary loop; ``id`` is what ``complete(holes=[...])`` takes."""

    id: int
    kind: Literal["hole", "rim"]
    edges: int
    length: float
    area: float
    component: int
    touches: list[int]
    defect: list[int] | None


class HolesReport(Report, total=False):
    """All boundary loops, and how many are holes and outer rims."""

    holes: int
    rims: int
    loops: list[Loop]


class InfoReport(Report, total=False):
    """What is in a scan."""

    vertices: int
    faces: int
    corners: list[dict[str, int]]
    channels: list[dict[str, Any]]
    colors: bool
    normals: bool
    extent: list[list[float]]
    diagonal: float
    edges: dict[str, float]
    pieces: int
    holes: int
    rims: int
    loose_vertices: int
    comments: list[str]
    sensors: list[dict[str, Any]]


class Counts(TypedDict):
    """How much was there, and how much came."""

    original_vertices: int
    original_faces: int
    completed_vertices: int
    completed_faces: int
    loops: int
    holes_left: int
    rims_left: int
    samples: int
    stray_vertices: int


class StepsWithin(TypedDict):
    """Steps within tiles as ratios to those between samples of the scan, for edges of the same direction and length."""

    heights: float | None
    colors: float | None


class WorstBorder(TypedDict):
    """The border between two tiles."""

    #: The tiles' numbers.
    tiles: list[int]
    heights: float | None
    colors: float | None
    #: Number of edges across it.
    edges: int


class Seams(TypedDict):
    """How well tiles fit together: steps from one completed vertex to the next across their borders, as ratios to those
    of edges of the same direction within tiles.

    1 where no border shows, None where nothing steps. What goes wrong without a step, such as a brick that ends at a
    border, is not seen.
    """

    #: Absolute differences of heights.
    heights: float | None
    #: Absolute differences of colours, over red, green and blue.
    colors: float | None
    #: Number of edges across borders.
    edges: int
    #: Of all pairs of tiles with at least 30 edges across their border the one with the greatest ratio.
    worst: WorstBorder | None
    within: StepsWithin


class CompletionReport(Report, total=False):
    """What was completed, and how; ``skipped`` says which gaps stayed open and why."""

    method: str
    seed: int
    parameters: dict[str, Any]
    base_fits: bool
    fit: dict[str, Any]
    free_form: dict[str, Any] | None
    chosen: list[dict[str, Any]]
    counts: Counts
    filled: list[dict[str, Any]]
    skipped: list[dict[str, Any]]
    searched: dict[str, Any]
    spacing: dict[str, float]
    seconds: list[dict[str, Any]]
    statistics: dict[str, Any]
    #: In tiles: their number, their rounds, the vertices of the largest.
    tiling: dict[str, int]
    #: In tiles: how well they fit together.
    seams: Seams


class Verdict(TypedDict):
    """What lies beyond natural variation, in figures and in words."""

    text: str
    beyond: list[dict[str, Any]]


class Part(TypedDict, total=False):
    """A part of a surface in figures; ``areal`` by the names of ISO 25178-2."""

    area: float
    areal: dict[str, float | None]
    mean_height: float
    mean_integral: float
    rms_roughness: float
    triangles: int


class _TwoParts(Report, total=False):
    """One part's relief and colors against another's."""

    base: dict[str, Any]
    mean_integral_difference_percent: float | None
    roughness_ratio: float | None
    heights: dict[str, Any]
    colors: dict[str, Any] | None
    spectrum: dict[str, Any] | None
    copies: dict[str, Any] | None
    natural: dict[str, Any] | None
    verdict: Verdict | None


class StatsReport(_TwoParts, total=False):
    """Original against completed part; or ``whole`` alone."""

    original: Part
    completed: Part
    whole: Part


class CompareReport(_TwoParts, total=False):
    """Two scans, or two parts of one, ``a`` and ``b``."""

    other: str
    a: Part
    b: Part


class TextureReport(Report, total=False):
    """How a mesh was textured."""

    method: str
    seed: int
    parameters: dict[str, Any]
    seconds: list[dict[str, Any]]


class TransferReport(Report, total=False):
    """How a texture was transferred."""

    seed: int
    parameters: dict[str, Any]
    seconds: list[dict[str, Any]]
