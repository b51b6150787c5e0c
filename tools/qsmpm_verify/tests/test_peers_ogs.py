"""OpenGeoSys: what is written of a model, what is read back, and closed forms where it is installed."""

import tempfile
import unittest
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from qsmpm_verify import peers_ogs
from qsmpm_verify.peers_model import Flow, _flow, read_blocks
from qsmpm_verify.tests.test_peers import SQUARE, confined
from qsmpm_verify.trouble import RunFailed, Trouble

MODULUS = 100 * 0.7 / (1.3 * 0.4)
WATER = """*NSET, NSET=top, PLANE=Y
 1
*PERMEABILITY, LAW=CONSTANT
 2e-5, 2e-5
*PHASE, NAME=load, TIME=0.2
*CONTROLS, STEPS=20,
 TOLERANCE=1e-8
*CONSOLIDATION, UNIT WEIGHT=10, STORAGE=0
 top, OPEN
"""


def draining(duration: float, steps: int = 1):  # noqa: ANN201
    """The square under a push of 3 that drains at its top."""
    return replace(confined(push=3.0), flow=Flow(2e-3, np.array([2, 3, 6]), duration, steps))


class Water(unittest.TestCase):
    def test_flow_of_a_deck(self) -> None:
        flow = _flow(read_blocks(WATER), SQUARE)
        self.assertAlmostEqual(flow.mobility, 2e-6, 15)
        self.assertEqual((flow.duration, flow.steps), (0.2, 20))
        self.assertEqual(flow.open.tolist(), [2, 3, 6])
        self.assertIsNone(_flow(read_blocks("*PHASE, NAME=load\n"), SQUARE))

    def test_flow_that_the_other_program_has_not_is_an_error(self) -> None:
        for old, new in (("STORAGE=0", "STORAGE=1e-5"), ("2e-5, 2e-5", "2e-5, 1e-5"), ("OPEN", "CLOSED")):
            self.assertRaisesRegex(Trouble, "only a single permeability", _flow, read_blocks(WATER.replace(old, new)), SQUARE)


class Written(unittest.TestCase):
    def test_the_mesh_has_the_same_numbers(self) -> None:
        nodes = np.array([(0.1, 1 / 3), (1e-17, 2.0), (3.0, 4.0)])
        root = ElementTree.fromstring(peers_ogs.mesh_text(nodes, np.array([[2, 0, 1]]), 5))
        data = {entry.get("Name"): (entry.text or "").split() for entry in root.iter("DataArray")}
        self.assertEqual([float(word) for word in data["Points"]], [0.1, 1 / 3, 0, 1e-17, 2, 0, 3, 4, 0])
        self.assertEqual((data["connectivity"], data["offsets"], data["types"]), (["2", "0", "1"], ["3"], ["5"]))

    def test_sets_have_the_numbers_of_the_whole_mesh_and_the_loads(self) -> None:
        files = peers_ogs.files_of(confined(push=3.0))
        self.assertEqual(set(files), {"model.prj", "whole.vtu", "held_x.vtu", "held_y.vtu", "loaded.vtu"})
        fields = peers_ogs.read_fields(files["loaded.vtu"])
        self.assertEqual(fields["bulk_node_ids"].ravel().tolist(), [2, 3, 6])
        np.testing.assert_allclose(fields["load_y"].ravel(), [-0.5, -0.5, -2.0])
        self.assertEqual(peers_ogs.read_fields(files["held_y.vtu"])["bulk_node_ids"].ravel().tolist(), [0, 1, 4])

    def test_the_project_without_loads_and_with_water(self) -> None:
        dry = ElementTree.fromstring(peers_ogs.files_of(confined(weight=2.0))["model.prj"])
        self.assertEqual(dry.findtext(".//process/type"), "SMALL_DEFORMATION")
        self.assertEqual(dry.findtext(".//specific_body_force"), "0.0 -2.0")
        self.assertIsNone(dry.find(".//source_term"))
        wet = ElementTree.fromstring(peers_ogs.files_of(draining(0.2, 4))["model.prj"])
        self.assertEqual(wet.findtext(".//process/type"), "HYDRO_MECHANICS")
        self.assertEqual([entry.text for entry in wet.findall(".//process_variable/order")], ["2", "1"])
        self.assertEqual((wet.findtext(".//repeat"), wet.findtext(".//delta_t"), wet.findtext(".//t_end")), ("4", "0.05", "0.2"))
        known = {entry.findtext("name"): entry.findtext("value") for entry in wet.findall(".//media//property")}
        self.assertEqual((known["permeability"], known["viscosity"], known["biot_coefficient"]), ("0.002", "1.0", "1.0"))

    def test_water_flows_in_quadratic_cells_only(self) -> None:
        model = replace(draining(1.0), cells=np.arange(4)[None, :], vtk_type=9)
        self.assertRaisesRegex(Trouble, "quadratic", peers_ogs.files_of, model)
        linear = peers_ogs.project_text(replace(model, flow=None), [])
        self.assertEqual(ElementTree.fromstring(linear).findtext(".//process_variable/order"), "1")


class Read(unittest.TestCase):
    def test_forces_of_supports_are_nodal_forces_and_loads_of_held_nodes(self) -> None:
        model = draining(1.0)
        moved, forces, pressure = np.arange(16.0).reshape(8, 2), np.ones((8, 2)), np.arange(8.0)[:, None]
        tables = [("displacement", moved), ("NodalForces", forces), ("pressure", pressure)]
        text = peers_ogs.mesh_text(SQUARE, model.cells, 23, "".join(peers_ogs._data(*table) for table in tables))
        found = peers_ogs.solution_of(model, text)
        np.testing.assert_array_equal(found.displacement, moved)
        np.testing.assert_array_equal(found.pressure, pressure[:, 0])
        np.testing.assert_allclose(found.reaction, [8.0 - 1.0, 8.0 - 1.0 + 1.0])  # node 6 is free and bears 2 of the 3
        self.assertIsNone(peers_ogs.solution_of(confined(), text).pressure)
        self.assertRaises(RunFailed, peers_ogs.solution_of, model, text.replace("displacement", "other"))


@unittest.skipUnless(peers_ogs.version(), "not installed: OpenGeoSys")
class Computed(unittest.TestCase):
    def go(self, model):  # noqa: ANN001, ANN201
        with tempfile.TemporaryDirectory() as folder:
            return peers_ogs.solve(model, Path(folder) / "ogs")[0]

    def test_confined_compression_is_the_closed_form(self) -> None:
        """Settlement p H / M + w H^2 / (2 M); the supports bear p + w."""
        found = self.go(confined(2.0, 1.0))
        self.assertAlmostEqual(-found.displacement[6, 1] * MODULUS, 2.0, 10)
        self.assertAlmostEqual(found.reaction[1], 3.0, 10)

    def test_water_leaves_by_permeability_times_time_and_bears_nothing_in_the_end(self) -> None:
        soon, late = self.go(draining(1.0)), self.go(draining(1e9))
        again = self.go(replace(confined(push=3.0), flow=Flow(4e-3, np.array([2, 3, 6]), 0.5, 1)))
        np.testing.assert_allclose(soon.displacement, again.displacement, atol=1e-12)
        self.assertLess(-soon.displacement[6, 1] * MODULUS, 2.9)
        self.assertGreater(soon.pressure[0], 1.0)
        self.assertAlmostEqual(-late.displacement[6, 1] * MODULUS, 3.0, 5)
        self.assertLess(abs(late.pressure).max(), 1e-5)


if __name__ == "__main__":
    unittest.main()
