"""Errors of linear cells for a bar of material points: loads on points, cells that points have crossed.

One dimension, linear shape functions, point volumes as integration weights (the standard method).
The correct value of every ratio is one; the functions give the results of an uncorrected method.
"""

from __future__ import annotations

import math

from qsmpm_verify.reference.arguments import between, positive, step_count


def surface_load_share(points_per_cell: float) -> float:
    """Fraction of a traction applied to the topmost points that the top cell receives.

    Formula: 1 - 1 / (2 ppc)
    Units: points per cell and direction [-]; result [-]
    Range: an integer number of equally spaced points; cells below the top one receive all of it
    Assumes: linear cells, load on the points nearest to the surface
    Source: own derivation, shape function of the top node at the top point
    Check: assembled bar of four cells solved for the nodal displacements
    """
    return 1 - 1 / (2 * step_count(points_per_cell))


def crossed_cell_stress(points: float, points_per_cell: float, stretch: float) -> float:
    """Stress over the correct one in a cell that contains k points of a uniformly compressed bar.

    Formula: sigma / F = ppc / (k lambda)
    Units: points k [-], initial points per cell [-], stretch [-]; result [-]
    Range: integer k of at least 1, lambda > 0
    Assumes: linear cells, point volumes as weights, unit area
    Source: own derivation, k lambda h / ppc is the volume that carries the force
    Check: assembled nodal forces of a compressed bar in equilibrium
    """
    positive(stretch=stretch)
    return step_count(points_per_cell) / (step_count(points) * stretch)


def _mean_count(points_per_cell: float, stretch: float) -> float:
    """Mean number of points in a cell of the stretched bar."""
    positive(stretch=stretch)
    mean = step_count(points_per_cell) / stretch
    between("points_per_cell / stretch", mean, low=1.0)
    return mean


def crossed_cell_highest(points_per_cell: float, stretch: float) -> float:
    """Largest stress over the correct one in a uniformly compressed bar.

    Formula: ppc / (floor(ppc / lambda) lambda)
    Units: points per cell [-], stretch [-]; result [-]
    Range: lambda < ppc: no cell without points
    Assumes: as crossed_cell_stress, points equally spaced
    Source: own derivation
    Check: assembled nodal forces of a long compressed bar
    """
    return _mean_count(points_per_cell, stretch) / math.floor(_mean_count(points_per_cell, stretch) + 1e-9)


def crossed_cell_lowest(points_per_cell: float, stretch: float) -> float:
    """Smallest stress over the correct one in a uniformly compressed bar.

    Formula: ppc / (ceil(ppc / lambda) lambda)
    Units: points per cell [-], stretch [-]; result [-]
    Range: lambda < ppc
    Assumes: as crossed_cell_stress, points equally spaced
    Source: own derivation
    Check: assembled nodal forces of a long compressed bar
    """
    return _mean_count(points_per_cell, stretch) / math.ceil(_mean_count(points_per_cell, stretch) - 1e-9)
