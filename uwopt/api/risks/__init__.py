"""What may go wrong with a system, by what it is about; `told` puts the most serious first."""
