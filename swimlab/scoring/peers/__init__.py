"""Other people's metrics as additional columns, one a file; they come with extras and are never the core."""
