#!/usr/bin/env python3
"""Fits base surfaces with SciPy, as other people's numbers for `base::fit`.

Writes data/golden/fits.json: for each kind a grid of points with smooth deterministic "noise" and a
few gross outliers, and the parameters that scipy.optimize.least_squares finds with the plain sum of
squared orthogonal distances and with Tukey's biweight of a fixed scale.

Needs numpy and scipy (written with 2.4 and 1.17). Usage: python3 scripts/golden_fits.py
"""

import json
import pathlib

import numpy as np
from scipy.optimize import least_squares

COLUMNS, ROWS = 14, 9
SCALE = 0.03  # of Tukey's biweight
REACH = 4.685  # its constant
OUTLIERS = slice(5, None, 17)

i = np.arange(COLUMNS * ROWS)
a, b = (i % COLUMNS) / (COLUMNS - 1), (i // COLUMNS) / (ROWS - 1)
# Sines of incommensurate frequencies: looks like noise, needs no generator.
noise = 0.02 * np.sin(12.9898 * i + 1.3) + 0.015 * np.sin(78.233 * i + 0.2)
noise[OUTLIERS] += 0.7


def frame(w):
    """Unit vectors u, v, w, pairwise perpendicular."""
    w = np.asarray(w, float) / np.linalg.norm(w)
    u = np.cross(w, np.eye(3)[np.argmin(abs(w))])
    u /= np.linalg.norm(u)
    return u, np.cross(w, u), w


U, V, W = frame([0.4, -0.5, 0.8])
ORIGIN = np.array([10.0, -3.0, 5.0])


def local(x, y, z):
    return ORIGIN + np.outer(x, U) + np.outer(y, V) + np.outer(z, W)


def points():
    angle = 2.2 * a
    polar = 0.4 + 1.0 * b
    r = 2.0 + noise
    sphere = local(r * np.sin(polar) * np.cos(angle), r * np.sin(polar) * np.sin(angle), r * np.cos(polar))
    r = 1.5 + noise
    cylinder = local(r * np.cos(angle), r * np.sin(angle), 3.0 * b)
    half_angle, slant = 0.5, 1.0 + 2.0 * b
    radius = slant * np.sin(half_angle) + noise * np.cos(half_angle)
    along = slant * np.cos(half_angle) - noise * np.sin(half_angle)
    cone = local(radius * np.cos(angle), radius * np.sin(angle), along)
    return {"plane": local(3.0 * a, 2.0 * b, noise), "sphere": sphere, "cylinder": cylinder, "cone": cone}


def tilted(c, d):
    w = W + c * U + d * V
    return w / np.linalg.norm(w)


def axis_coordinates(p, x):
    n = tilted(x[2], x[3])
    e = p - (ORIGIN + x[0] * U + x[1] * V)
    t = e @ n
    return np.linalg.norm(e - np.outer(t, n), axis=1), t


HEIGHT = {
    "plane": lambda x, p: (p - ORIGIN) @ tilted(x[0], x[1]) - x[2],
    "sphere": lambda x, p: np.linalg.norm(p - ORIGIN - x[:3], axis=1) - x[3],
    "cylinder": lambda x, p: axis_coordinates(p, x)[0] - x[4],
    "cone": lambda x, p: np.cos(x[5]) * (axis_coordinates(p, x)[0] - x[4])
    - np.sin(x[5]) * axis_coordinates(p, x)[1],
}
START = {
    "plane": [0.0, 0.0, 0.0],
    "sphere": [0.0, 0.0, 0.0, 2.0],
    "cylinder": [0.0, 0.0, 0.0, 0.0, 1.5],
    "cone": [0.0, 0.0, 0.0, 0.0, 0.0, 0.5],
}


def surface(kind, x, p):
    """Parameters as `BaseSurface` has them."""
    if kind == "plane":
        n = tilted(x[0], x[1])
        center = p.mean(axis=0)
        return {"point": center - n * ((center - ORIGIN) @ n - x[2]), "normal": n}
    if kind == "sphere":
        return {"center": ORIGIN + x[:3], "radius": x[3]}
    n = tilted(x[2], x[3])
    q = ORIGIN + x[0] * U + x[1] * V
    if kind == "cylinder":
        return {"point": q + n * ((p.mean(axis=0) - q) @ n), "axis": n * np.sign(n[np.argmax(abs(n))]), "radius": x[4]}
    return {"apex": q - n * x[4] / np.tan(x[5]), "axis": n, "half_angle": x[5]}


def tukey(z):
    """SciPy's rho(z), z = (height / (REACH * SCALE))^2, with its first two derivatives."""
    rest = np.maximum(1.0 - z, 0.0)
    return np.array([(1.0 - rest**3) / 3.0, rest**2, -2.0 * rest])


def main():
    cases = []
    for kind, p in points().items():
        # What the test reads is what was fitted.
        p = np.array([[float(repr(float(c))) for c in q] for q in p])
        case = {"kind": kind, "points": p.tolist()}
        for name, loss, f_scale in [("least_squares", "linear", 1.0), ("tukey", tukey, REACH * SCALE)]:
            tight = dict(xtol=1e-15, ftol=1e-15, gtol=1e-15, max_nfev=5000, x_scale="jac")
            x = START[kind]
            # Restarts, because the robust steps of SciPy are small near the minimum.
            for _ in range(3):
                fit = least_squares(HEIGHT[kind], x, args=(p,), jac="3-point", loss=loss, f_scale=f_scale, **tight)
                x = fit.x
            parameters = surface(kind, fit.x, p)
            parameters = {k: np.asarray(v).tolist() for k, v in parameters.items()}
            rms = float(np.sqrt(np.mean(HEIGHT[kind](fit.x, p) ** 2)))
            case[name] = {"surface": {"kind": kind, **parameters}, "rms": rms}
            print(f"{kind:9} {name:14} rms {rms:.6f} gradient {np.abs(fit.grad).max():.1e} {parameters}")
        cases.append(case)
    golden = {"columns": COLUMNS, "rows": ROWS, "scale": SCALE, "cases": cases}
    path = pathlib.Path(__file__).resolve().parent.parent / "data" / "golden" / "fits.json"
    path.write_text(json.dumps(golden) + "\n")


if __name__ == "__main__":
    main()
