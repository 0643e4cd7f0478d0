"""Settings that a person can set: marks of lenses, steps of cameras and lamps."""
