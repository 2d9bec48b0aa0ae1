"""Anyone's frames: what a pattern names, how it is read as linear radiance, and how its motion is given."""
