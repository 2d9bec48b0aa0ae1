"""`python -m swimlab`: the command line, where the program is not on the path."""

from swimlab.cli.main import main

if __name__ == "__main__":  # processes that are started by spawn read this file too
    main()
