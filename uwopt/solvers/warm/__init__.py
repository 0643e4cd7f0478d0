"""Many missions that differ in some keys, each solved with what is known of those before it."""
