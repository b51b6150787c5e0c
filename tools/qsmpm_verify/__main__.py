"""`python -m qsmpm_verify`."""

import sys

from qsmpm_verify.cli import main

sys.exit(main())
