"""What can be bought: records, loading, estimates, compatibility, generic parts."""
