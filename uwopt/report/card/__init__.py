"""The settings card: one page to print and take to sea."""
