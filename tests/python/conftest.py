"""Shared set-up of the Python tests: make `reference`, `fleet` and each test file importable from every folder."""

from __future__ import annotations

import os
import signal
import sys
from pathlib import Path

# If a shell starts the tests in the background, they ignore Ctrl-C, which some tests send.
signal.signal(signal.SIGINT, signal.default_int_handler)
HERE = Path(__file__).parent
FOLDERS = [str(HERE), *(str(path) for path in sorted(HERE.iterdir()) if path.is_dir())]
sys.path[:0] = FOLDERS
# The programs that tests start import the same modules.
os.environ["PYTHONPATH"] = os.pathsep.join(filter(None, [*FOLDERS, os.environ.get("PYTHONPATH")]))
