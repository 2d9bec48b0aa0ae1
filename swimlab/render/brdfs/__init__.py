"""One reflectance model a file. A file here is found by itself (see `registry`)."""
