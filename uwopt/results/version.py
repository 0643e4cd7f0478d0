"""The version of the program, apart from all that needs it."""

__version__ = "0.1.0"
