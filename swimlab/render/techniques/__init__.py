"""Techniques, one a file: the order in which it filters and shades. `runs/registry.py` finds every file here."""
