"""The forward model of a mission: parts as columns, tables of light, figures of many designs at once."""
