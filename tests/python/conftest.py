"""Shared set-up of the Python tests: make the folder `reference` importable from every test."""

from __future__ import annotations

import signal
import sys
from pathlib import Path

# If a shell starts the tests in the background, they ignore Ctrl-C, which some tests send.
signal.signal(signal.SIGINT, signal.default_int_handler)
sys.path.insert(0, str(Path(__file__).parent))
