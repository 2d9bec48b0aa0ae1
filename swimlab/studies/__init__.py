"""Studies beyond the scores: one a file, each makes a table of a report."""
