"""How to show it: tables, bill of materials, result files."""
