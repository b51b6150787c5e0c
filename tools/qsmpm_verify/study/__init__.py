"""`study`: a user's own deck over grids, methods and steps; what its answer is, how sure, and what it costs to know it.

cards       a deck as its cards
variants    the same scene on a finer or coarser grid, by another method, in more steps
band        the value a sequence of grids goes to, and the band around it
search      runs in the order of their cost, within a budget of time
judgement   the answer of all runs, and the cheapest one that is close enough
telling     tables, the drawing, figures.json and the deck of the choice
verb        words of the command line
"""
