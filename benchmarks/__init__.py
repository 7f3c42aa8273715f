"""One run, one table: how fast springpot is, and what the alternatives take for the same work.

``make bench`` runs it; ``python -m benchmarks --quick`` shows in a minute that every part of it works.
"""
