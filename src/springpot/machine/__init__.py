"""Threads, Ctrl-C, files, trust, words of errors, progress: nothing of physics."""
