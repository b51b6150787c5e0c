"""Run QSMPM decks, compare their results with references, and draw them.

reference  closed forms and published figures, each with formula, source and units
results    what a run wrote: curves.csv and the material points of results.h5
cases      verification/cases/*.toml: deck, quantities, references, tolerances
runner     runs the program on the decks of cases
judge      compares the figures of a finished run with its references
measures   figures computed from all material points of a state
report     tables, JSON and the closing line
plots      figures
cli        the command line
"""
