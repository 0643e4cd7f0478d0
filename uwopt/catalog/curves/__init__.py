"""Curves: spectra, phase functions, photometric files, curves of users."""
