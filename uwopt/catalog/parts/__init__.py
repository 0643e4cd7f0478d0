"""One model a kind of part; each field is declared once, and files, records, checks and lists follow from it.

A new field is one line in the file of its kind; an estimate for parts that do not state it is a row
`kind-field-class` of class_estimates.csv; what the model computes with is a line in its table in hardware.py.
What a row or an inline record says in other words than the record keeps is the business of `read_<kind>.py`.
"""
