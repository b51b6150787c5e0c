"""`import`: a section drawn in another program as a deck: DXF drawings and projects of GeoStudio, Slide2 and RS2.

Data of a file without a counterpart in a deck are listed, never dropped silently; data required by a deck but missing in the file are requested
in a table or reported with the assumed value.
"""
