"""Writes the pressures of reservoir.toml as a simulator would: cells of two blocks beside a leaning fault, in bar.

python fields.py, with meshio and NumPy
"""
import math

import meshio
import numpy as np

LEVEL, DIP = -2050.0, math.radians(70)
WIDTH, COLUMNS, LAYERS, THICKNESS = 100.0, 15, 4, 25.0


def block(side, top):
    """Points and cells between the fault and the end of the model; side is -1 to the west and 1 to the east."""
    points, cells = [], []
    for y in (0.0, 100.0):
        for k in range(LAYERS + 1):
            z = top - THICKNESS * k
            fault = (z - LEVEL) / math.tan(DIP)
            end = side * WIDTH * COLUMNS
            points += [(fault + (end - fault) * i / COLUMNS, y, z) for i in range(COLUMNS + 1)]
    at = lambda i, j, k: i + (COLUMNS + 1) * (k + (LAYERS + 1) * j)
    for k in range(LAYERS):
        for i in range(COLUMNS):
            ring = [(i, 0), (i + 1, 0), (i + 1, 1), (i, 1)]
            cells.append([at(a, b, k) for a, b in ring] + [at(a, b, k + 1) for a, b in ring])
    return np.array(points), np.array(cells)


def pressure(x, z, years):
    """A well in the west draws 110 bar in twenty years; a tenth of it passes the fault."""
    initial = 205.0 + 0.1 * (-2000.0 - z)
    share = 1.0 - math.exp(-years / 8.0)
    if x < 0.0:
        return initial - share * (80.0 + 40.0 * math.exp(-(((x + 600.0) / 300.0) ** 2)))
    return initial - share * 25.0 * math.exp(-x / 500.0)


west, east = block(-1, -2000.0), block(1, -2050.0)
points = np.vstack([west[0], east[0]])
cells = np.vstack([west[1], east[1] + len(west[0])])
centers = points[cells].mean(axis=1)
for years in (0, 5, 20):
    values = np.array([pressure(x, z, years) for x, _, z in centers])
    mesh = meshio.Mesh(points, [("hexahedron", cells)], cell_data={"PRESSURE": [values]})
    mesh.write(f"year_{years:02}.vtu")
