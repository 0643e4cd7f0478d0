"""Explore a design: plots as files, and the page with every control."""
