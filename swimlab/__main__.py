"""The program `swimlab`, and `python -m swimlab`, where that is not on the path."""

import sys


def main() -> None:
    """Load the command line and run it. An interrupt meanwhile ends it with 130, as one later does."""
    try:
        from swimlab.cli.main import main
    except KeyboardInterrupt:
        sys.exit(130)
    main()


if __name__ == "__main__":  # processes that are started by spawn read this file too
    main()
