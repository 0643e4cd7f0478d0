"""Planted defects: small patches of the program, each with the test that must fail when it is applied.

One file an area holds `DEFECTS`; `python tests/planted/run.py` plants them one by one.
"""
