"""How well a motion fits its frames: every pair of them, long baselines, and what does not fit."""
