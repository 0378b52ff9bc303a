"""Scenes and programs that `benches/compare.py` compares."""
