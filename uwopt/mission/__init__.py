"""What is wanted and what is given: mission and system files, their keys, checks and templates."""
