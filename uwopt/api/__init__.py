"""The public functions: arguments are checked, rooms are called, results are put together."""
