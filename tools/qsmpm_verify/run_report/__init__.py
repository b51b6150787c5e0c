"""`report RUN`: one run as a self-contained page and as a document: phases, factor, curves, figures, warnings, deck."""
