"""Measurements of QSMPM: seconds, memory and rates of whole processes, medians of interleaved runs.

    measure   run a process and measure its CPU seconds, memory and profile; medians and spreads
    decks     decks of the measurements: those of input/ with replacements, and blocks of soil
    tables    tables as Markdown and CSV, and the sections of docs/data/performance.md
    charts    log-log lines and bars
    machine   the rate of the matrix product on the machine
    context   settings of a study
    blocks    studies on blocks: rates by basis, sizes, empty cells, a million points
    shares    studies on the decks of the tree: parts of the time, threads, selection of the model, solvers
    peers     scenes compared with other programs
    cli       the command `tools/bench`
"""
