"""Vectors of hardware and settings for the evolutionary algorithms of pymoo."""
