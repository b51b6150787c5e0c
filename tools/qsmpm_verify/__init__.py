"""Run QSMPM decks, compare their results with references, and draw them.

The command line (cli) hands each verb to a module of its own:

batch      list, run: the cases of verification/cases
curve      curve: any result against a formula or a table
library    functions, references: the formulas as a list, in full, as the page docs/references.md
chart      chart: error against cost; studies (their files), sampling (their runs), front (what is worth its cost)
study      study: a user's own deck over grids, methods and steps, with the band of its answer (a folder of its own)
week       week: scenes of a first week by default settings, beside hand values and plans
metamorphic  metamorphic: scenes in other frames answer the same; frames (the decks of them)
stability_map  map: tests where methods fail; stability (their files), mapping (how a method comes out)
peers      peers: the same scenes in other programs; peers_scenes (their files), peers_model and peers_loads (what is taken
           from a run), peers_calculix and peers_kratos (the programs), peers_runs (runs kept), peers_compute, peers_judge
view       view: bodies by a field; fields (values), bodies, body_net, outlines, cells and plane_picture (in the plane), stage (VTK, in space)
document   report: one page of everything; hypertext (its pieces)
pictures   plot, points, figures

What they share:

reference  closed forms and published figures, each with formula, source and units
formula    such a form as the command line names it
units      what the units in headings mean
results    what a run wrote: curves.csv and the material points of results.h5
cases      verification/cases/*.toml: deck, quantities, references, tolerances; families: one entry, many cases
runner     runs the program on decks; cache: runs that need not be repeated; progress: how far it is
judge      compares the figures of a finished run with its references
measures   figures computed from all material points of a state; traces: from the course of a run
report     tables, JSON and the closing line
plots      figures
trouble    errors and their exit codes; places: where things lie
"""
