"""Reading files of keys and values: YAML with lines, types of keys, faults by place; knows no mission."""
