"""Curves, maps, drawings and simulated photographs of a report."""
