"""`study`: a user's deck with several grids, methods and steps; its result, the uncertainty, and the cost.

cards       a deck as its keyword blocks
variants    the same scene on a finer or coarser grid, with another method, in more steps
band        the limit of a sequence of grids, and the uncertainty band around it
search      runs in order of their cost, within a time budget
judgement   the result of all runs, and the cheapest sufficiently accurate run
telling     tables, the chart, figures.json and the deck of the selected run
verb        arguments of the command line
"""
