"""The command line: the only room that prints and exits."""

INTERRUPTED, NO_RESULT = 130, "uwopt: interrupted before there was a result."
