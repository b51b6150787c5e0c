"""Twenty small scenes whose factor of safety is known: slopes, vertical cuts, strips, samples, thick cylinders, a dam's
face under water. Each is a deck and its truth; `verification/study_answers.py --factors` studies them all.

Truths: logarithmic spirals and circles (Chen 1975; Taylor 1937; for the cut of clay the bounds 3.776 to 3.778 of Pastor,
Thai & Francescato 2000), Prandtl 1920, uniform states of stress, plastic zones of thick cylinders (Hill 1950), Davis 1968.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from qsmpm_verify.reference import REFERENCES


@dataclass(frozen=True)
class FactorScene:
    """A deck and its factor of safety."""

    name: str
    text: str
    truth: float
    source: str


def root(spare: Callable[[float], float], low: float = 0.05, high: float = 20.0) -> float:
    """Where a falling function is zero."""
    for _ in range(80):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if spare(middle) > 0.0 else (low, middle)
    return 0.5 * (low + high)


def soil(c: float, phi: float, psi: float, weight: float = 0.0, locking: bool = True) -> str:
    """The cards of the one material."""
    return "\n".join([
        "*MATERIAL, NAME=soil", "*ELASTIC", "30000, 0.3", "*MOHR COULOMB", f"{c:g}, {phi:g}, {psi:g}",
        *(["*VOLUMETRIC LOCKING, TYPE=UNIFORM PRESSURE"] if locking else []), *(["*UNIT WEIGHT", f"{weight:g}"] if weight else []),
    ])  # fmt: skip


def searched(flow: str = "MATERIAL") -> str:
    """The phase of the search."""
    return f"*PHASE, NAME=factor, TYPE=SAFETY\n*SAFETY, FLOW={flow}\n*END PHASE\n"


def slope(angle: float, c: float, phi: float, weight: float, psi: float | None = None, flow: str = "MATERIAL", height: float = 4.0) -> str:
    """A slope on the plane of its toe, eight cells high."""
    run = height / math.tan(math.radians(angle)) if angle < 90 else 0.0
    crest = height * math.ceil(1.5 + 0.02 * max(0.0, 45.0 - phi))
    length = height * math.ceil((crest + run) / height)
    return f"""*HEADING
Slope of {angle:g} degrees
*MODEL, TYPE=PLANE STRAIN
*GRID, ELEMENT=QUAD4
X, 0, {length:g}, {8 * round(length / height)}
Y, 0, {height:g}, 8
*NSET, NSET=base, PLANE=Y
0
*NSET, NSET=left, PLANE=X
0
{soil(c, phi, phi if psi is None else psi, weight)}
*BODY, NAME=slope, MATERIAL=soil, SHAPE=POLYGON
0, 0
{crest + run:.6g}, 0
{crest:g}, {height:g}
0, {height:g}
*FIELD, VTK=NO, HDF5=NO
*PHASE, NAME=built
*FIX
base, ALL
left, X
*GRAVITY
0, -1
*CONTROLS, STEPS=4
*END PHASE
""" + searched(flow)


def strip(c: float, phi: float, pressure: float) -> str:
    """A flexible strip of half width 1 on soil without weight."""
    return f"""*HEADING
Flexible strip
*MODEL, TYPE=PLANE STRAIN
*GRID, ELEMENT=QUAD4
X, 0, 6, 24
Y, 0, 3, 12
*NSET, NSET=base, PLANE=Y
0
*NSET, NSET=sides, PLANE=X
0
*NSET, NSET=right, PLANE=X
6
{soil(c, phi, phi)}
*BODY, NAME=ground, MATERIAL=soil, SHAPE=BOX
0, 6, 0, 3
*SURFACE, NAME=strip, TYPE=OUTLINE, BODY=ground, BOX
0, 1, 3, 3
*FIELD, VTK=NO, HDF5=NO
*PHASE, NAME=loaded
*FIX
base, ALL
sides, X
right, X
*TRACTION, SURFACE=strip
0, {-pressure:g}
*CONTROLS, STEPS=4
*END PHASE
""" + searched()


def sample(c: float, phi: float, psi: float, axial: float, side: float, model: str = "PLANE STRAIN", young: str = "30000") -> str:
    """A sample between smooth plates under uniform stress."""
    return f"""*HEADING
Uniform stress
*MODEL, TYPE={model}
*GRID, ELEMENT=QUAD4
X, 0, 2, 8
Y, 0, 2, 8
*NSET, NSET=base, PLANE=Y
0
*NSET, NSET=axis, PLANE=X
0
{soil(c, phi, psi, locking=False).replace("30000", young)}
*BODY, NAME=sample, MATERIAL=soil, SHAPE=BOX
0, 1, 0, 1.5
*SURFACE, NAME=top, TYPE=OUTLINE, BODY=sample, BOX
0, 1, 1.5, 1.5
*SURFACE, NAME=side, TYPE=OUTLINE, BODY=sample, BOX
1, 1, 0, 1.5
*FIELD, VTK=NO, HDF5=NO
*PHASE, NAME=loaded
*FIX
base, Y
axis, X
*TRACTION, SURFACE=top
0, {-axial:g}
*TRACTION, SURFACE=side
{-side:g}, 0
*CONTROLS, STEPS=4
*END PHASE
""" + searched()


def cylinder(c: float, phi: float, inside: float, outside: float) -> str:
    """A slice of a thick cylinder, radii 1 and 3, under pressure from inside."""
    return f"""*HEADING
Thick cylinder
*MODEL, TYPE=AXISYMMETRIC
*GRID, ELEMENT=QUAD4
X, 0, 4, 32
Y, 0, 0.125, 1
*NSET, NSET=base, PLANE=Y
0
*NSET, NSET=lid, PLANE=Y
0.125
{soil(c, phi, phi)}
*BODY, NAME=wall, MATERIAL=soil, SHAPE=BOX
1, 3, 0, 0.125
*SURFACE, NAME=bore, TYPE=OUTLINE, BODY=wall, BOX
1, 1, 0, 0.125
*SURFACE, NAME=rim, TYPE=OUTLINE, BODY=wall, BOX
3, 3, 0, 0.125
*FIELD, VTK=NO, HDF5=NO
*PHASE, NAME=loaded
*FIX
base, Y
lid, Y
*PRESSURE, SURFACE=bore
{inside:g}
*PRESSURE, SURFACE=rim
{outside:g}
*CONTROLS, STEPS=4
*END PHASE
""" + searched()


def sample_factor(c: float, phi: float, axial: float, side: float) -> float:
    """Uniform stress: (s1 - s3)/2 = c/F cos phi_F + (s1 + s3)/2 sin phi_F."""
    def spare(factor: float) -> float:
        angle = math.atan(math.tan(math.radians(phi)) / factor)
        return c / factor * math.cos(angle) + 0.5 * (axial + side) * math.sin(angle) - 0.5 * (axial - side)

    return root(spare)


def strip_factor(c: float, phi: float, pressure: float) -> float:
    """Prandtl: q = c/F N_c(phi_F)."""
    def spare(factor: float) -> float:
        angle = math.atan(math.tan(math.radians(phi)) / factor)
        flow = math.exp(math.pi * math.tan(angle)) * math.tan(math.pi / 4 + angle / 2) ** 2
        bearing = 2.0 + math.pi if phi == 0 else (flow - 1.0) / math.tan(angle)
        return c / factor * bearing - pressure

    return root(spare)


def cylinder_factor(c: float, phi: float, inside: float, outside: float) -> float:
    """All of the wall yields: 2 c/F ln 3, or (p + c cot phi) falls as r to the power of 1/N - 1."""
    def spare(factor: float) -> float:
        angle = math.atan(math.tan(math.radians(phi)) / factor)
        if phi == 0:
            return outside + 2.0 * c / factor * math.log(3.0) - inside
        cone = (1.0 + math.sin(angle)) / (1.0 - math.sin(angle))
        pull = c / factor / math.tan(angle)
        return (outside + pull) * 3.0 ** (1.0 - 1.0 / cone) - pull - inside

    return root(spare)


def spiral(angle: float, c: float, phi: float, weight: float, height: float = 4.0) -> float:
    """The best logarithmic spiral through the toe."""
    return REFERENCES["slope_spiral_safety"](unit_weight=weight, cohesion=c, friction=phi, angle=angle, height=height)


def factor_scenes() -> list[FactorScene]:
    """The scenes."""
    made = [
        FactorScene(f"slope_{angle:g}_{phi:g}", slope(angle, c, phi, weight), spiral(angle, c, phi, weight), "logarithmic spiral")
        for angle, c, phi, weight in ((45, 10, 25, 20), (60, 12, 20, 18), (30, 6, 15, 18), (26.565, 4, 20, 20), (75, 15, 30, 20), (45, 5, 35, 25), (90, 16, 15, 18))
    ]
    davis = REFERENCES["slope_davis_a_safety"](unit_weight=18, cohesion=10, friction=30, dilatancy=0, angle=50, height=4)
    made += [
        FactorScene("slope_davis", slope(50, 10, 30, 18, 0.0, "DAVIS A"), davis, "spiral, Davis A"),
        FactorScene("slope_davis_part", slope(40, 6, 28, 19, 8.0, "DAVIS A"), REFERENCES["slope_davis_a_safety"](
            unit_weight=19, cohesion=6, friction=28, dilatancy=8, angle=40, height=4), "spiral, Davis A"),
        FactorScene("clay_60", slope(60, 20, 0, 18), 5.244 * 20 / (18 * 4), "Taylor: toe circle, 5.24"),
        FactorScene("clay_75", slope(75, 20, 0, 18), 4.566 * 20 / (18 * 4), "Taylor: toe circle, 4.57"),
        FactorScene("cut_clay", slope(90, 25, 0, 18), 3.777 * 25 / (18 * 4), "3.776 to 3.778"),
    ]  # fmt: skip
    made += [
        FactorScene(name, strip(*given), strip_factor(*given), "Prandtl")
        for name, given in (("strip_clay", (20, 0, 70)), ("strip_friction", (8, 15, 60)))
    ]
    made += [
        FactorScene("sample_sand", sample(2, 33, 0, 90, 40), sample_factor(2, 33, 90, 40), "uniform stress"),
        FactorScene("sample_soft", sample(15, 22, 22, 70, 20, young="3000"), sample_factor(15, 22, 70, 20), "uniform stress, soft"),
        FactorScene("sample_clay", sample(25, 0, 0, 60, 24), sample_factor(25, 0, 60, 24), "uniform stress"),
        FactorScene("triaxial", sample(6, 28, 10, 100, 45, "AXISYMMETRIC"), sample_factor(6, 28, 100, 45), "uniform stress"),
        FactorScene("cylinder_clay", cylinder(20, 0, 50, 20), cylinder_factor(20, 0, 50, 20), "Hill"),
        FactorScene("cylinder_friction", cylinder(10, 25, 60, 20), cylinder_factor(10, 25, 60, 20), "all of the wall yields"),
    ]  # fmt: skip
    return made
