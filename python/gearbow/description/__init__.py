"""What a user describes: parts of a system, their plain form, and what follows from them alone."""
