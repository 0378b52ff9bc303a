"""Results of the analyses. A result contains arrays and coordinates, not the system."""
