"""Typed results of solve, evaluate and pareto, to JSON and back."""
