"""The verbs of the command line, each from its own module."""

import contextlib
import io
import subprocess
import sys
import unittest

from qsmpm_verify.cli import HOMES, main, parser
from qsmpm_verify.places import TOP


class Verbs(unittest.TestCase):
    def test_each_is_where_it_is_looked_for(self) -> None:
        for home, own in HOMES.items():
            self.assertEqual(tuple(parser(own[0])._subparsers._group_actions[0].choices), own, home)

    def test_help_and_a_mistake_tell_all_of_them(self) -> None:
        for words, code in (["--help"], 0), (["runs"], 2), ([], 2):
            said = io.StringIO()
            with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said), self.assertRaises(SystemExit) as end:
                main(words)
            self.assertEqual(end.exception.code, code)
            for verb in (verb for own in HOMES.values() for verb in own if words):
                self.assertIn(verb, said.getvalue())

    def test_a_list_imports_nothing_that_draws(self) -> None:
        script = "import sys; from qsmpm_verify.cli import main; code = main(['list']); sys.exit(code or 'matplotlib' in sys.modules)"
        subprocess.run([sys.executable, "-c", script], cwd=TOP / "tools", check=True, capture_output=True)


if __name__ == "__main__":
    unittest.main()
