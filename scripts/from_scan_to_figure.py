#!/usr/bin/env python3
"""From a scan to a figure: a notebook as a script (cells begin with `# %%`; VS Code, Spyder and Jupytext open it so).

    pip install relievo matplotlib
    scripts/from_scan_to_figure.py [FOLDER]

writes figure.png and completed.ply to FOLDER, by default the one it is run in.
"""

# %% What is needed
from __future__ import annotations

import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
import relievo

SCANS = Path(__file__).resolve().parents[1] / "data" / "scans"
FOLDER = Path(sys.argv[1]) if len(sys.argv) > 1 else Path()

# %% A scan, and what is open in it
scan = relievo.read(SCANS / "bricks-hole.ply")
print(scan)
for loop in relievo.holes(scan)["loops"]:
    print(f"{loop['kind']} {loop['id']}: {loop['edges']} edges, {loop['length']:.2f} around")

# %% What lies under the relief
fit = relievo.fit(scan)
print(f"{fit['base']['kind']}; relief {fit['inlier_rms']:.4f} (RMS)")

# %% Complete the hole
done = relievo.complete(scan)
counts = done.report["counts"]
print(f"{counts['completed_vertices']} new vertices, {counts['completed_faces']} new faces")
relievo.write(done.scan, FOLDER / "completed.ply", overwrite=True)

# %% Does the completed part pass as original?
stats = relievo.stats(done.scan)
if stats["verdict"] is not None:
    print(stats["verdict"]["text"])

# %% Heights over the base surface, of both parts: from the report's histograms
new = done.scan.channels["completed"] == 1
heights = stats["heights"]
edges = np.linspace(heights["lowest"], heights["highest"], len(heights["original"]["shares"]) + 1)

# %% The figure: before, after, what is new, and how heights are spread
figure, axes = plt.subplots(2, 2, figsize=(10, 8))
view = {"size": (800, 600), "no_legend": True}
pictures = [
    ("What the scanner saw", relievo.render(scan, **view)),
    ("Completed", relievo.render(done.scan, **view)),
    ("What is new", relievo.render(done.scan, channel="completed", **view)),
]
for axis, (title, picture) in zip(axes.flat, pictures, strict=False):
    axis.imshow(picture)
    axis.set_title(title)
    axis.axis("off")
last = axes.flat[3]
for part in ("original", "completed"):
    last.stairs(heights[part]["shares"], edges, label=part)
last.set_title("Heights over the base surface")
last.set_xlabel("height in the scan's unit")
last.set_ylabel("share of the area")
last.legend()
figure.tight_layout()
figure.savefig(FOLDER / "figure.png", dpi=100)
print(f"{int(new.sum())} of {done.scan.n_vertices} vertices are new; see {FOLDER / 'figure.png'}")
