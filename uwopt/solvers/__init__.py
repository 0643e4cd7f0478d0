"""How to choose: exact search, continuous solvers on given hardware, explanations."""
