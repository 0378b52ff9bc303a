"""Reports: the results of a system as one HTML page with interactive figures."""
