"""`report RUN`: one run as a page that needs no other file, and as a document: phases, factor, curves, pictures, warnings, deck."""
