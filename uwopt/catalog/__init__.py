"""What can be bought: parts as records, loading, class estimates, choice, compatibility, spectra."""
