"""Rows of files and inline keys made into parts, with estimates for what they lack."""
