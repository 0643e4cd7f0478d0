"""Settings as a smooth program: CasADi with IPOPT and Bonmin, and NLopt."""
