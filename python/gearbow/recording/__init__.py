"""What a simulation recorded: plain data, access by name, energy, files and tables."""
