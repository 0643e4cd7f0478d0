"""What stands beside an optimum: doubts, other waters, lamp places, other makers' systems."""
