"""Run QSMPM decks, compare their results with references, and draw them.

The command line (cli) passes each subcommand to its own module:

batch      list, run: the cases of verification/cases
curve      curve: any result against a formula or a table
library    functions, references: the formulas as a list, in full, or as the page docs/references.md
chart      chart: error against cost; studies (their files), sampling (their runs), front (most efficient runs)
study      study: a user's deck with several grids, methods and steps, and the band of its result (own folder)
week       week: scenes of a first week with default settings, with hand values and plans
metamorphic  metamorphic: transformed scenes give the same results; frames (their decks)
stability_map  map: tests where methods fail; stability (their files), mapping (outcome of a method)
peers      peers: the same scenes in other programs; peers_scenes (their files), peers_model and peers_loads (data taken
           from a run), peers_calculix and peers_kratos (the programs), peers_runs (runs kept), peers_compute, peers_judge
view       view: bodies by a field; fields (values), bodies, body_net, outlines, cells and plane_picture (in the plane), stage (VTK, in space)
document   report: one page of all results; hypertext (its elements)
pictures   plot, points, figures

Common modules:

reference  closed forms and published figures, each with formula, source and units
formula    a closed form as named on the command line
units      meaning of units in headings
results    output of a run: curves.csv and the material points of results.h5
cases      verification/cases/*.toml: deck, quantities, references, tolerances; families: several cases from one entry
runner     runs the program on decks; cache: reuse of finished runs; progress: progress of a batch
judge      compares the results of a finished run with its references
measures   quantities of all material points of a state; traces: of the history of a run
report     tables, JSON and the closing line
plots      figures
trouble    errors and their exit codes; places: paths
"""
