"""The sections of a mission file: vehicle, requirements, limits, catalog, and its scenes.

Each key is a field with its limits and a description; messages and the JSON schema are made from them.
"""
