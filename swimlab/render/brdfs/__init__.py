"""Reflectance models, one a file. `runs/registry.py` finds every file here."""
