"""Queries over the scores of many runs, in SQL."""
