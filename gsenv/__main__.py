"""`python -m gsenv`: the same as the `gsenv` command."""

import sys

from gsenv.cli import main

if __name__ == "__main__":
    sys.exit(main())
