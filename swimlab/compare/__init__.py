"""Scores of runs side by side, and over time: what changed, by how much, and whether that is more than chance."""
