"""Physics `full` computed a second time, for the tests, from the physics page and the tables that ship.

Rays, spectra, veils and the integral over the image by brute force in NumPy, every wavelength at every point. It uses
nothing of uwopt but those tables. Backscatter is integrated with vectors along each ray, r for r, without the
substitutions of `uwopt.model.veil`.
"""
