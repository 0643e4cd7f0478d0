"""One model a kind of part; each field is declared once, and files, records, checks and lists follow from it."""
