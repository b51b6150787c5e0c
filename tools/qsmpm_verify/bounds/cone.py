"""Stresses inside the yield cones: the maximum of a linear objective, by the interior-point method of Clarabel.

A stress point has three unknowns, m = (s_x + s_y)/2, d = (s_x - s_y)/2 and t_xy, tension positive. Mohr-Coulomb in the plane is a second-order cone:

    |(d, t_xy)| <= c cos(phi) - (m + u) sin(phi)            u: pore pressure

and a tension cut-off T is |(d, t_xy)| <= T - (m + u). The last unknown multiplies the live loads (LOAD), or is subtracted from the right-hand side of the cones
of Mohr-Coulomb (MARGIN; a free face has no margin below a tensile strength of 0); a FORCE has none.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum

import numpy as np
import scipy.sparse as sparse

from qsmpm_verify.results import Array
from qsmpm_verify.trouble import Trouble

TOLERANCE = 1e-6
SOLVED = "Solved"


class Kind(Enum):
    """The objective that is maximised."""

    LOAD = "load"
    MARGIN = "margin"
    FORCE = "force"


@dataclass(frozen=True)
class Yield:
    """Cones at points: their apex values without stress, slopes with m, change of pore pressure with the load, share of the margin subtracted from them;
    their points."""

    point: Array
    head: Array
    slope: Array
    pore: Array
    margin: Array


@dataclass(frozen=True)
class Balance:
    """Equations: matrix on the stresses, right-hand side without and with one unit of the live load; the objective of a FORCE.
    The last unknowns are forces between minus and plus their `limits`. Triangles that are `still` have no stresses."""

    matrix: sparse.csr_matrix
    dead: Array
    live: Array
    figure: Array | None = None
    limits: Array = field(default_factory=lambda: np.empty((0, 2)))
    still: Array = field(default_factory=lambda: np.empty(0, dtype=bool))


@dataclass(frozen=True)
class Joint:
    """Points between soil and rigid bodies: |t| <= a - n tan(delta) there, and n <= 0 where they separate freely, both linear in the unknowns; tangents,
    adhesions, which separate."""

    pull: sparse.csr_matrix
    shear: sparse.csr_matrix
    friction: Array
    adhesion: Array
    parts: Array


@dataclass(frozen=True)
class Answer:
    """The maximum, the status of the solver, stresses (points, 3), duals of equations; of the cones the points, duals of their
    heads, heads."""

    value: float
    status: str
    stress: Array
    motion: Array
    point: Array
    rate: Array
    head: Array

    @property
    def solved(self) -> bool:
        """Whether the solver status is Solved; no other result is a bound."""
        return self.status == SOLVED


def _cone_rows(cones: Yield, kind: Kind, unknowns: int) -> tuple[sparse.csr_matrix, Array]:
    """Rows A and right-hand side b of the condition that b - A x is in the cones."""
    count = len(cones.point)
    row, column = 3 * np.arange(count), 3 * cones.point
    rows, columns = [row, row + 1, row + 2], [column, column + 1, column + 2]
    values = [cones.slope, np.full(count, -1.0), np.full(count, -1.0)]
    if kind is not Kind.FORCE:
        rows.append(row)
        columns.append(np.full(count, unknowns - 1))
        values.append(cones.margin if kind is Kind.MARGIN else cones.slope * cones.pore)
    matrix = sparse.csr_matrix((np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))), (3 * count, unknowns))
    right = np.zeros(3 * count)
    right[::3] = cones.head
    return matrix, right


def _joint_rows(joint: Joint, unknowns: int) -> tuple[sparse.csr_matrix, Array]:
    """Rows and right-hand side: apex and shear of each point in turn, then the tensions."""
    count = len(joint.friction)
    order = np.arange(2 * count).reshape(2, count).T.ravel()
    rows = sparse.vstack([sparse.vstack([sparse.diags(joint.friction) @ joint.pull, -joint.shear]).tocsr()[order], joint.pull[joint.parts]])
    wide = sparse.hstack([rows, sparse.csr_matrix((rows.shape[0], unknowns - rows.shape[1]))])
    right = np.zeros(rows.shape[0])
    right[: 2 * count : 2] = joint.adhesion
    return sparse.csr_matrix(wide), right


def _limit_rows(limits: Array, first: int, unknowns: int) -> tuple[sparse.csr_matrix, Array]:
    """Rows and right-hand side of the existing limits, for unknowns from `first` on."""
    number, side = np.nonzero(np.isfinite(limits))
    shape = (len(number), unknowns)
    return sparse.csr_matrix((np.where(side == 0, -1.0, 1.0), (np.arange(len(number)), first + number)), shape), limits[number, side]


def largest(balance: Balance, cones: Yield, kind: Kind, joint: Joint | None = None) -> Answer:
    """The maximum live load, margin or force."""
    try:
        import clarabel
    except ImportError as error:
        raise Trouble("bounds require the Python package clarabel: run tools/setup again, or pip install 'qsmpm[verify]'") from error
    equations, stresses = balance.matrix.shape
    extra = kind is not Kind.FORCE
    unknowns = stresses + extra
    stresses -= len(balance.limits)
    matrix = balance.matrix
    if extra:
        live = -balance.live if kind is Kind.LOAD else np.zeros(equations)
        matrix = sparse.hstack([matrix, sparse.csr_matrix(live[:, None])])
    rows, right = _cone_rows(cones, kind, unknowns)
    kinds = [clarabel.ZeroConeT(equations), *[clarabel.SecondOrderConeT(3)] * len(cones.point)]
    if joint is not None:
        further, beside = _joint_rows(joint, unknowns)
        rows, right = sparse.vstack([rows, further]), np.concatenate([right, beside])
        kinds += [*[clarabel.SecondOrderConeT(2)] * len(joint.friction), clarabel.NonnegativeConeT(int(joint.parts.sum()))]
    if len(balance.limits):
        further, beside = _limit_rows(balance.limits, stresses, unknowns)
        rows, right = sparse.vstack([rows, further]), np.concatenate([right, beside])
        kinds.append(clarabel.NonnegativeConeT(len(beside)))
    whole = sparse.csc_matrix(sparse.vstack([matrix, rows]))
    used = np.ones(unknowns, dtype=bool)
    used[: 9 * len(balance.still)] = ~np.repeat(balance.still, 9)
    figure = np.zeros(unknowns)
    if kind is Kind.FORCE:
        assert balance.figure is not None
        figure = -balance.figure
    else:
        figure[-1] = -1.0
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.max_threads = 1
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = TOLERANCE
    empty = sparse.csc_matrix((int(used.sum()), int(used.sum())))
    found = clarabel.DefaultSolver(empty, figure[used], whole[:, np.flatnonzero(used)], np.concatenate([balance.dead, right]), kinds, settings).solve()
    x, z, s = np.zeros(unknowns), np.array(found.z), np.array(found.s)
    x[used] = found.x
    last = equations + 3 * len(cones.point)
    return Answer(
        -float(found.obj_val), str(found.status), x[:stresses].reshape(-1, 3), z[:equations], cones.point, z[equations:last:3], s[equations:last:3],
    )  # fmt: skip
