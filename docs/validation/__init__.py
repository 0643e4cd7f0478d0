"""The sections of docs/validation.md, one module each; `docs/make_validation.py` puts them together.

A section computes its numbers from measurements, tables or code of its own, and asks uwopt only for the
column that is held against them.
"""
