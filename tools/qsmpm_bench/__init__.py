"""Measurements of QSMPM: seconds, memory and rates of whole processes, medians of interleaved runs.

    measure   run a process and take its CPU seconds, memory and profile; medians and spreads
    decks     decks of the measurements: those of input/ with replacements, and blocks of soil
    tables    tables as Markdown and CSV, and the sections of docs/data/performance.md
    charts    log-log lines and bars
    machine   the rate of the machine's matrix product
    context   what every study is given
    blocks    studies on blocks: rates by basis, sizes, empty cells, a million points
    shares    studies on the decks of the tree: parts of the time, threads, choice of the model, solvers
    peers     scenes beside other programs
    cli       the command `tools/bench`
"""
