"""Parameter sweeps: measures of many systems, computed in parallel and stored in a file."""
