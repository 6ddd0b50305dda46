"""Prints a row of the table of evaluate_scenes.sh: SCENE FILL REPORT."""

import json
import statistics
import sys

scene, fill, path = sys.argv[1:]
try:
    with open(path, encoding="utf-8") as file:
        report = json.load(file)
except OSError:
    print(f"| {scene} | {fill} | failed without a report |" + " |" * 9)
    sys.exit()
if report["status"] == "failed":
    print(f"| {scene} | {fill} | {report['error']} |" + " |" * 9)
    sys.exit()
repeats = report["repeats"]


def median(get, digits=2):
    """Median over the holes that have the figure."""
    values = []
    for repeat in repeats:
        try:
            values.append(get(repeat))
        except (TypeError, ZeroDivisionError):  # null in the report, or no relief at all
            pass
    return f"{statistics.median(values):.{digits}f}" if values else "-"


outside = ", ".join(
    f"{m['measure']} {m['worst']:.1f}" for m in report["measures"] if m["outside"] > 0
)
cells = [
    scene,
    fill,
    median(lambda r: r["completed"]["sq"] / r["original"]["sq"]),
    median(lambda r: r["completed"]["sdq"] / r["original"]["sdq"]),
    f"{report['overall']['median']:.2f}",
    outside or "none",
    median(lambda r: r["against_truth"]["rmse"] / r["original"]["sq"]),
    median(lambda r: r["against_truth"]["mean_integral_difference_percent"], 1),
    median(lambda r: min(r["color_correlation"])),
    median(lambda r: r["copies"]["neighboring_edges"]),
    median(lambda r: r["copies"]["largest_piece"]),
    median(lambda r: r["seconds"], 1),
]
print("| " + " | ".join(cells) + " |")
