"""``python -m trackmetrics``."""

import sys

from trackmetrics.cli import main

sys.exit(main())
