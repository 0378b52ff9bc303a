"""The total error of the accuracy levels, measured on twelve scenes."""
