"""Files of other programs and of measurements: rotors of ROSS, and CSV tables."""
