"""Description of a system: its parts, their plain form, and their geometry and kinematics."""
