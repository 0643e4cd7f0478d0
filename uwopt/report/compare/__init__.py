"""Systems side by side: rows, text, page and table of a comparison."""
