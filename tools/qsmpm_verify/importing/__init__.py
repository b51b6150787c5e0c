"""`import`: a section that other programs have drawn, as a deck: DXF drawings and GeoStudio projects.

What a file says and a deck has no counterpart for is listed, never dropped; what a deck needs and the file does not say is asked
for in a table or named with the value that was taken.
"""
