"""What stands beside an optimum: doubts, other waters, lamp places, why nothing fits, alternatives."""
