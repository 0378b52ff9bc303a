"""Shared set-up of the Python tests: the folder `reference` is importable from every test."""

from __future__ import annotations

import signal
import sys
from pathlib import Path

# A shell that starts the tests in the background lets them ignore Ctrl-C, which some tests send.
signal.signal(signal.SIGINT, signal.default_int_handler)
sys.path.insert(0, str(Path(__file__).parent))
