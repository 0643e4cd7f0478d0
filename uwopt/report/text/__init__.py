"""Results as text and tables: words, layout, verdict, doubts, terminal."""
