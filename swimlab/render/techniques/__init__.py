"""One technique a file: the order in which it filters and shades. A file here is found by itself (see `registry`)."""
