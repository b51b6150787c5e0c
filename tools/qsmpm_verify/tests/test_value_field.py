"""*FIELD OF VALUES by files of HDF5: the bytes of a run by CSV, what is missing in them, and a run that goes on from a restart file."""

import subprocess
import tempfile
import unittest
from pathlib import Path

import h5py
import numpy as np

from qsmpm_verify.places import PROGRAM, TOP

DECK = (TOP / "verification/cases/decks/value_block.inp").read_text(encoding="utf-8")
TABLE = (TOP / "verification/cases/decks/value_block.csv").read_text(encoding="utf-8")


@unittest.skipUnless(PROGRAM.is_file(), "the program is not built")
class ValueField(unittest.TestCase):
    def setUp(self) -> None:
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)
        (self.folder / "value_block.csv").write_text(TABLE)
        (self.folder / "csv.inp").write_text(DECK[: DECK.index("*PHASE, NAME=factor")])
        (self.folder / "hdf5.inp").write_text(DECK[: DECK.index("*PHASE, NAME=factor")].replace(".csv", ".h5"))

    def run_deck(self, name: str, *words: str) -> subprocess.CompletedProcess[str]:
        out = self.folder / name
        return subprocess.run([PROGRAM, "run", self.folder / f"{name}.inp", "--out", out, "--quiet", *words], capture_output=True, text=True, check=False)

    def write(self, **other: list[float] | None) -> None:
        """The columns as data sets; those that are given are others, or none."""
        columns = np.genfromtxt(self.folder / "value_block.csv", delimiter=",", names=True)
        with h5py.File(self.folder / "value_block.h5", "w") as file:
            for name in columns.dtype.names:
                values = other.get(name, columns[name].tolist())
                if values is not None:
                    file[name] = values

    def test_a_run_by_hdf5_is_that_by_csv(self) -> None:
        self.write()
        for name in ("csv", "hdf5"):
            done = self.run_deck(name)
            self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(*((self.folder / name / "curves.csv").read_bytes() for name in ("csv", "hdf5")))
        log = (self.folder / "csv" / "job.log").read_text()
        for told in ("c from 4 to 6 by place", "phi from 28 to 32 by place", "E from 1000 to 2000 by place", "gamma from 17 to 20 by place"):
            self.assertIn(f"material 'soil': {told}", log)

    def test_what_is_wrong_in_a_file_is_said(self) -> None:
        for other, why in (({"y": None}, "there is no data set 'y'"), ({"phi": [30.0]}, "data set 'phi' has another size than 'x'"),
                           ({"phi": [30.0, 30.0, 30.0, float("nan")]}, "sample 4: a number is not finite"),
                           ({"E": [1.0, 1.0, 0.0, 1.0]}, "sample 3: E = 0 is outside (0, inf)")):
            self.write(**other)
            done = self.run_deck("hdf5")
            self.assertEqual(done.returncode, 2)
            self.assertIn(why, done.stderr)

    def test_the_check_tells_the_weight_of_each_phase(self) -> None:
        deck = (TOP / "verification/cases/decks/undrained_column.inp").read_text(encoding="utf-8")
        for old, new in (("*UNDRAINED, TYPE=A, NU=0.495\n", "*UNIT WEIGHT\n20\n*MATERIAL, NAME=lighter\n*ELASTIC\n1000, 0.3\n*UNIT WEIGHT\n11\n"
                          "*FIELD OF VALUES\ngamma, value_block.csv\n"), ("*HISTORY, NAME=pressure, QUANTITY=STATE, STATE=excess_pore_pressure\n0.25, 1\n", ""),
                         ("*TRACTION, SURFACE=top\n0, -100\n", "*GRAVITY\n0, -1\n"), ("*DRAIN STATE\n", "*CHANGE MATERIAL\nlayer, lighter\n")):
            self.assertIn(old, deck)
            deck = deck.replace(old, new)
        (self.folder / "stages.inp").write_text(deck)
        (self.folder / "value_block.csv").write_text("x,y,gamma\n0,0,18\n1,0,18\n0,4,10\n1,4,10\n")
        done = subprocess.run([PROGRAM, "check", self.folder / "stages.inp"], capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        weights = [float(line.split("weight")[1].split()[1].rstrip(",")) for line in done.stdout.splitlines() if line.startswith("phase '")]
        self.assertEqual(weights, [-40.0, -28.0, -28.0])

    def test_places_beyond_the_samples_are_told(self) -> None:
        (self.folder / "value_block.csv").write_text(TABLE.replace("1,", "0.1,", 1).replace("\n1,", "\n0.1,"))
        done = self.run_deck("csv")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(done.stderr.count("warning: *FIELD OF VALUES: "), 1)
        x, y = np.meshgrid(0.025 + 0.05 * np.arange(20), 0.025 + 0.05 * np.arange(16))
        away = np.hypot(np.maximum(0.0, x - 0.1), np.maximum(0.0, np.maximum(0.2 - y, y - 0.6)))
        far = int((away > np.hypot(0.1, 0.4) / 2.0).sum())
        self.assertRegex(done.stderr, rf"{far} of 320 points of material 'soil' are outside the range of the samples of '\S+value_block.csv', as at \(0.975, ")


if __name__ == "__main__":
    unittest.main()
