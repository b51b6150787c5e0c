"""`python -m qsmpm_bench`."""

import sys

from qsmpm_bench.cli import main

sys.exit(main())
