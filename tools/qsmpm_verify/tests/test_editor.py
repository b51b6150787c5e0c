"""Decks in an editor: the table, the grammar and its snippets, and the language server asked by a real client."""

import asyncio
import contextlib
import io
import json
import re
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

from lsprotocol import types
from pygls.lsp.client import LanguageClient

from qsmpm_verify.cli import main
from qsmpm_verify.editor.deck_text import names_in, offers
from qsmpm_verify.editor.grammar import grammar, snippets
from qsmpm_verify.editor.server import diagnostics_of, help_at
from qsmpm_verify.editor.table import explained, read_table
from qsmpm_verify.places import PROGRAM, TOP

DECK = """*MODEL, TYPE=PLANE STRAIN
*GRID, ELEMENTT=QUAD4
X, 0, 1, 2
Y, 0, 1, 2
*MATERIAL, NAME=stiff clay
*ELASTIC
1000, 0.3
*BODY, NAME=ground, MATERIAL=
0, 1, 0, 1
*PHASE, NAME=weight,
"""


@unittest.skipUnless(PROGRAM.is_file(), "the program is not built")
class Editor(unittest.TestCase):
    def setUp(self) -> None:
        self.table = read_table(PROGRAM)
        self.lines = DECK.split("\n")

    def offered(self, line: int, column: int | None = None) -> list[str]:
        return [name for name, _ in offers(self.table, self.lines, line, len(self.lines[line]) if column is None else column)]

    def test_the_table_has_every_keyword_of_help(self) -> None:
        listed = subprocess.run([PROGRAM, "help"], capture_output=True, text=True, check=True).stdout
        names = [line[1:24].strip() for line in listed.splitlines() if line.startswith("*")]
        self.assertEqual(list(self.table.keywords), names)
        steps = self.table.parameter("CONTROLS", "steps")
        self.assertEqual((steps["kind"], steps["range"]), ("integer", "[1, 1000000]"))
        self.assertIn("\n", self.table.keywords["BODY"]["example"])

    def test_all_examples_are_coloured_as_keywords(self) -> None:
        patterns = {p.get("name") or p["captures"]["1"]["name"]: re.compile(p["match"], re.MULTILINE) for p in grammar(self.table)["patterns"]}
        for name, entry in self.table.keywords.items():
            self.assertRegex(f"*{name}, A=B", patterns["keyword.control.qsmpm"], name)
            for line in entry["example"].split("\n"):
                if line.lstrip().startswith("*") and not line.lstrip().startswith("**"):
                    self.assertRegex(line.strip(), patterns["keyword.control.qsmpm"])
        self.assertNotRegex("*GRIDD", patterns["keyword.control.qsmpm"])
        self.assertEqual(patterns["constant.numeric.qsmpm"].findall("1, -2.5e-3, x1, .5"), ["1", "-2.5e-3", ".5"])
        self.assertEqual(snippets(self.table)["*FIX"]["body"][0], "*FIX")

    def test_what_fits_at_the_cursor_is_offered(self) -> None:
        self.assertIn("MOHR COULOMB", self.offered(1, 2))
        self.assertIn("DIAGONAL", self.offered(1, 7))
        self.assertEqual(self.offered(7), ["stiff clay"])
        self.assertIn("TYPE", self.offered(9))
        self.assertNotIn("NAME", self.offered(9))
        self.assertEqual(self.offered(2), [])
        self.assertEqual(names_in(self.lines, "BODY"), ["ground"])

    def test_help_is_that_of_the_word_at_the_pointer(self) -> None:
        self.assertEqual(help_at(self.table, self.lines, 5, 3), explained(self.table.keywords["ELASTIC"]))
        self.assertEqual(help_at(self.table, self.lines, 6, 2), explained(self.table.keywords["ELASTIC"]))
        self.assertIn("name of its material", help_at(self.table, self.lines, 7, 25))

    def test_every_keyword_and_parameter_is_offered_and_explained(self) -> None:
        """Hundreds of positions: each keyword behind a star, its parameters behind a comma, help on both."""
        positions = 0
        for name, entry in self.table.keywords.items():
            self.assertIn(name, [offered for offered, _ in offers(self.table, ["*"], 0, 1)], name)
            self.assertEqual(help_at(self.table, [f"*{name}"], 0, 3), explained(entry), name)
            offered = [word for word, _ in offers(self.table, [f"*{name}, "], 0, len(name) + 3)]
            for item in entry["parameters"]:
                self.assertIn(item["name"], offered, name)
                line = f"*{name}, {item['name']}=1"
                self.assertIn(item["sentence"], help_at(self.table, [line], 0, len(name) + 4), line)
                positions += 2
            positions += 2
        self.assertGreater(positions, 300)

    def test_messages_stand_at_their_lines(self) -> None:
        report = "a.inp:2: *GRID: unknown\na.inp:3: warning: thin\nother.inp:9: *BODY: bad\na.inp: 2 errors in the deck\n"
        found = diagnostics_of(report, "a.inp", ["one", "two", "three"])
        self.assertEqual([(d.range.start.line, d.severity, d.message) for d in found], [
            (1, types.DiagnosticSeverity.Error, "*GRID: unknown"), (2, types.DiagnosticSeverity.Warning, "thin"),
            (0, types.DiagnosticSeverity.Warning, "other.inp:9: *BODY: bad")])  # fmt: skip

    def test_the_extension_is_written_whole(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            with contextlib.redirect_stdout(io.StringIO()):
                self.assertEqual(main(["editor", "--out", folder]), 0)
            package = json.loads((Path(folder) / "package.json").read_text())
            for kind in ("grammars", "snippets"):
                self.assertTrue((Path(folder) / package["contributes"][kind][0]["path"]).is_file())
            self.assertTrue((Path(folder) / package["main"]).is_file())

    def test_a_client_gets_errors_completion_and_help(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            asyncio.run(asyncio.wait_for(self.talk(Path(folder)), 60))

    async def talk(self, folder: Path) -> None:
        client = LanguageClient("test", "1")
        marks: asyncio.Queue[types.PublishDiagnosticsParams] = asyncio.Queue()

        @client.feature(types.TEXT_DOCUMENT_PUBLISH_DIAGNOSTICS)
        def marked(found: types.PublishDiagnosticsParams) -> None:
            marks.put_nowait(found)

        await client.start_io(sys.executable, "-m", "qsmpm_verify", "language-server", cwd=TOP / "tools")
        await client.initialize_async(types.InitializeParams(types.ClientCapabilities()))
        client.initialized(types.InitializedParams())
        uri = (folder / "deck.inp").as_uri()
        client.text_document_did_open(types.DidOpenTextDocumentParams(types.TextDocumentItem(uri, "qsmpm", 1, DECK)))
        first = (await marks.get()).diagnostics
        self.assertIn((1, "*GRID: unknown parameter 'ELEMENTT' (did you mean ELEMENT?)"), [(d.range.start.line, d.message) for d in first])
        document = types.TextDocumentIdentifier(uri)
        offered = await client.text_document_completion_async(types.CompletionParams(document, types.Position(7, len(self.lines[7]))))
        self.assertEqual([item.label for item in offered], ["stiff clay"])
        hover = await client.text_document_hover_async(types.HoverParams(document, types.Position(5, 2)))
        self.assertIn("**\\*ELASTIC**", hover.contents.value)
        client.text_document_did_change(types.DidChangeTextDocumentParams(
            types.VersionedTextDocumentIdentifier(2, uri),
            [types.TextDocumentContentChangeWholeDocument((TOP / "input/footing.inp").read_text())]))  # fmt: skip
        self.assertEqual([d for d in (await marks.get()).diagnostics if d.severity == types.DiagnosticSeverity.Error], [])
        self.assertEqual(list(folder.iterdir()), [])
        await client.shutdown_async(None)
        client.exit(None)
        await client.stop()


if __name__ == "__main__":
    unittest.main()
