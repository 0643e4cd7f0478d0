"""The exact front of power, cost and quality, with a bound on what it may miss."""
