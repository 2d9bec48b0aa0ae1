"""Sweeps: a grid of sequences, techniques and settings, rendered and measured in tasks that can be done anywhere."""
