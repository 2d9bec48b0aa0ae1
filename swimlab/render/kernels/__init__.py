"""Device functions by topic: no launch, no file, no state. Everything a technique does to a sample is here once."""
