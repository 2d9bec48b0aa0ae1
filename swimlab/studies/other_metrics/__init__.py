"""What other metrics make of errors that differ only in how they change in time."""
