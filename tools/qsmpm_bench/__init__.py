"""Measurements of QSMPM: seconds, memory and rates of whole processes, medians of interleaved runs.

    measure   run a process and take its CPU seconds, memory and profile; medians and spreads
    decks     decks of the measurements: those of input/ with replacements, and blocks of soil
    tables    tables as Markdown and CSV, and the sections of docs/performance.md
    charts    log-log lines and stacked bars
    studies   one function a subcommand (blocks, shares, sizes, peers in modules of their own)
    cli       the command `tools/bench`
"""
