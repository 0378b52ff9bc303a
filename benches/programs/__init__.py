"""What `benches/compare.py` compares: the scenes, and the programs that simulate them."""
