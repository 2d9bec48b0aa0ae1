"""From a run folder or frames of your own to scores: `metrics` does the measuring."""
