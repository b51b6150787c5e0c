"""`reliability`: uncertain parameters of a deck, and the probability that a result exceeds its limit."""
