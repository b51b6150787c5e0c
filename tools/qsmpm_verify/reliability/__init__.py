"""`reliability`: numbers of a deck that are not known for sure, and the probability that an answer is on the wrong side of its limit."""
