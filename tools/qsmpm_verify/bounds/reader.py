"""Keywords of the model: bodies, materials, surfaces and node sets.

Keywords without influence on a limit load (stiffness, method, steps, histories) are ignored; any other keyword is an error that names it.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from qsmpm_verify.bounds.lines import closed, healed
from qsmpm_verify.bounds.scene import Material, Prop, Surface, Wall
from qsmpm_verify.bounds.strength import Strength, profile_of
from qsmpm_verify.bounds.words import OTHER_LAWS, PASSED, box_of, grid_lines, name_of, numbers, only, rectangle, refuse
from qsmpm_verify.results import Array
from qsmpm_verify.study.cards import Card, Deck, plain
from qsmpm_verify.trouble import Trouble

# Share of a cell of the grid within which bodies and sets touch: the program's mesh takes nearer places for one.
TOUCHING = 0.05


class Reader:
    """Keywords of the model in their order, then those of the phases up to the requested one."""

    def __init__(self, deck: Deck) -> None:
        self.deck = deck
        self.bodies: dict[str, Array] = {}
        self.body_materials: dict[str, str] = {}
        self.absent: set[str] = set()
        self.materials: dict[str, Material] = {}
        self.surfaces: dict[str, Surface] = {}
        self.sets: dict[str, tuple[Array, Array]] = {}
        self.walls: dict[str, Wall] = {}
        self.props: dict[str, Prop] = {}
        self.touching: set[str] = set()
        self.said: list[str] = []
        self.units = ("", "")
        grid = deck.find("GRID")
        if grid is None:
            raise Trouble("no *GRID: bounds support bodies defined on a grid only")
        self.steps = grid_lines(grid)
        self.near = TOUCHING * min(float(np.diff(lines).min()) for lines in self.steps)
        self.on_lines = grid.value("ELEMENT") is not None and grid.value("FIT") != "YES"
        self.material = ""
        words: dict[str, Callable[[Card], None]] = {
            "MODEL": self.model, "GRID": lambda card: None, "PERMEABILITY": lambda card: None,
            "BODY": self.body, "MATERIAL": self.begin_material, "SURFACE": self.surface,
            "NSET": self.node_set, "MOHR COULOMB": self.mohr_coulomb, "UNIT WEIGHT": self.unit_weight, "UNDRAINED": self.undrained,
            "STRENGTH PROFILE": self.profile, "FIELD OF VALUES": self.values, "RIGID BODY": self.rigid_body, "CONTACT": self.contact,
            "PROP": self.prop,
        }  # fmt: skip
        for card in deck.cards:
            if card.keyword == "PHASE":
                break
            if card.keyword == "UNITS":
                self.units = (name_of(card, "LENGTH"), name_of(card, "FORCE"))
            if card.keyword in OTHER_LAWS:
                self.now(refused=f"*{card.keyword} of material '{self.material}'")
            elif card.keyword in words:
                words[card.keyword](card)
            elif card.keyword not in PASSED:
                raise refuse(card, "not supported by limit analysis")

    def now(self, **changes: object) -> None:
        """Change the material that is being read."""
        self.materials[self.material] = replace(self.materials[self.material], **changes)  # type: ignore[arg-type]

    def model(self, card: Card) -> None:
        """Plane strain."""
        only(card, TYPE=("PLANE STRAIN", "AUTO"))

    def body(self, card: Card) -> None:
        """A box, a polygon or the whole grid."""
        only(card, SHAPE=("BOX", "POLYGON", "ALL"))
        name, rows = name_of(card, "NAME"), card.data()
        x, y = self.steps
        shape = card.value("SHAPE")
        if shape == "POLYGON":
            places = np.array([numbers(card, row, 2, 2) for row in rows])
        else:
            places = rectangle(*(box_of(card, rows[0]) if shape == "BOX" else (np.array([x[0], y[0]]), np.array([x[-1], y[-1]]))))
        turn = np.roll(places, -1, axis=0)
        if float(np.sum(places[:, 0] * turn[:, 1] - turn[:, 0] * places[:, 1])) < 0.0:
            places = places[::-1]
        self.bodies[name], self.body_materials[name] = healed(places, list(self.bodies.values()), self.near), name_of(card, "MATERIAL")
        if card.value("ACTIVE") == "NO":
            self.absent.add(name)

    def begin_material(self, card: Card) -> None:
        """The following properties belong to this material."""
        self.material = name_of(card, "NAME")
        self.materials[self.material] = Material()

    def mohr_coulomb(self, card: Card) -> None:
        """c, phi, psi and a tension cut-off."""
        row = card.data()[0]
        cut = row[3] if len(row) > 3 and plain(row[3]) not in ("", "NONE") else None
        c, phi, psi = numbers(card, row[:3], 3)
        tension = numbers(card, [cut], 1)[0] if cut is not None else None
        self.now(strength=Strength(c, phi, psi, tension))

    def unit_weight(self, card: Card) -> None:
        """Unit weights above and below the water level."""
        values = numbers(card, card.data()[0], 1, 2)
        self.now(weight=values[0], saturated=values[-1])

    def undrained(self, card: Card) -> None:
        """With phi = 0 the strength is that of total stresses."""
        if card.value("TYPE") not in ("B", "C"):
            self.now(refused=f"*UNDRAINED, TYPE=A of material '{self.material}'")

    def profile(self, card: Card) -> None:
        """Cohesion as a function of position."""
        only(card, TYPE=("LINEAR", "TABLE"), ALONG=("X", "Y"))
        strength = self.materials[self.material].strength
        if strength is None:
            raise refuse(card, "is before *MOHR COULOMB; bounds require it after")
        rows = [numbers(card, row, 2, 3) for row in card.data()]
        axis = 0 if card.value("ALONG") == "X" else 1
        levels = profile_of(card.value("TYPE") or "LINEAR", rows, strength.cohesion)
        self.now(strength=replace(strength, profile=levels, axis=axis))

    def values(self, card: Card) -> None:
        """Parameters from samples: stiffness and permeability do not change a limit load."""
        for row in card.data():
            if plain(row[0]) not in ("E", "K"):
                raise refuse(card, f"{plain(row[0])} from samples is not linear on the triangles, as a rigorous bound requires; *STRENGTH PROFILE by depth is")

    def rigid_body(self, card: Card) -> None:
        """A box, a polygon or a plane whose normal points to the soil; without ROUND edges are sharp."""
        only(card, SHAPE=("BOX", "POLYGON", "PLANE"), IN_PLACE=("NO",))
        rows, shape = card.data(), card.value("SHAPE")
        if shape == "PLANE":
            x, y, across, up = numbers(card, rows[0], 4, 4)
            far = 4.0 * max(float(np.ptp(lines)) for lines in self.steps) / math.hypot(across, up)
            place, along = np.array([x, y]), np.array([-up, across]) * far
            sides = np.array([[place - along, place + along]])
        else:
            places = rectangle(*box_of(card, rows[0])) if shape == "BOX" else np.array([numbers(card, row, 2, 2) for row in rows])
            turn = np.roll(places, -1, axis=0)
            if float(np.sum(places[:, 0] * turn[:, 1] - turn[:, 0] * places[:, 1])) < 0.0:
                places = places[::-1]
            sides = closed(places)
        self.walls[name_of(card, "NAME")] = Wall(sides)

    def prop(self, card: Card) -> None:
        """Two points; without limits the capacity is unbounded."""
        row = [word.split("=")[-1] for word in card.data()[0]]
        limits = (float(card.value("COMPRESSION LIMIT") or "inf"), float(card.value("TENSION LIMIT") or "inf"))
        self.props[name_of(card, "NAME")] = Prop(np.array(numbers(card, row, 4, 4)).reshape(2, 2), card.value("FIXED") == "YES", limits)

    def contact(self, card: Card) -> None:
        """The surface in contact with a body, and the friction and adhesion."""
        only(card, TENSION=("NO",))
        body = name_of(card, "BODY")
        if body not in self.walls:
            raise refuse(card, f"rigid body '{body}' is not defined")
        given = {key: float(card.value(key) or "nan") for key in ("FRICTION ANGLE", "ADHESION", "INTERFACE") if card.value(key) is not None}
        surface = name_of(card, "SURFACE") if card.value("SURFACE") is not None else ""
        self.walls[body] = replace(
            self.walls[body], surface=surface, friction=math.tan(math.radians(given.get("FRICTION ANGLE", 0.0))),
            adhesion=given.get("ADHESION", 0.0), share=given.get("INTERFACE"),
        )  # fmt: skip
        self.touching.add(body)

    def surface(self, card: Card) -> None:
        """Surfaces for loads or supports."""
        only(card, TYPE=("BOX", "SEGMENT", "OUTLINE"))
        rows, kind = card.data(), card.value("TYPE") or "BOX"
        if kind == "SEGMENT":
            places = np.array([numbers(card, row, 4, 4) for row in rows]).reshape(-1, 2, 2)
        else:
            places = np.array(box_of(card, rows[0])) if rows else np.array([[-np.inf] * 2, [np.inf] * 2])
        self.surfaces[name_of(card, "NAME")] = Surface(kind, places, name_of(card, "BODY") if kind == "OUTLINE" else "")

    def node_set(self, card: Card) -> None:
        """A plane or a box; on an element that does not fit a box ends at the last lines of the grid in it, as the nodes do."""
        name, rows = name_of(card, "NSET"), card.data()
        plane = card.value("PLANE")
        if plane in ("X", "Y"):
            axis, at = "XY".index(plane), numbers(card, rows[0], 1, 1)[0]
            low, high = np.full(2, -np.inf), np.full(2, np.inf)
            low[axis] = high[axis] = at
        elif card.value("BOX") is not None:
            low, high = box_of(card, rows[0])
            for axis, lines in enumerate(self.steps if self.on_lines else ()):
                slack = 1e-6 * (lines[-1] - lines[0])
                inside = lines[(lines >= low[axis] - slack) & (lines <= high[axis] + slack)]
                if len(inside):
                    low[axis], high[axis] = inside[0], inside[-1]
        else:
            raise refuse(card, f"'{name}' by node labels; bounds support PLANE or BOX only")
        self.weld(name, low, high)
        self.sets[name] = (low, high)

    def weld(self, name: str, low: Array, high: Array) -> None:
        """Ends of a node box moved to those of earlier sets if the distance is small: no triangle is as narrow, and ground in between is constrained by neither."""
        for other, ends in self.sets.items():
            if np.any(low > ends[1] + self.near) or np.any(high < ends[0] - self.near):
                continue
            for mine, axis, end in ((mine, axis, end) for mine in (low, high) for axis in range(2) for end in ends):
                miss = abs(mine[axis] - end[axis])
                if 0.0 < miss < self.near and end[axis] not in (low[axis], high[axis]):
                    self.said.append(f"set '{name}' ends {miss:.3g} from set '{other}' along {'XY'[axis]}: treated as touching")
                    mine[axis] = end[axis]
