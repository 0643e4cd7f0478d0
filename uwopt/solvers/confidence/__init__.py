"""Whether a design holds in the doubt: scenarios of what is uncertain, and the hardware that holds in most of them."""
