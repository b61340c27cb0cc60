"""`python -m lagrangian_ff.cli`."""

import sys

from lagrangian_ff.cli.main import main

if __name__ == "__main__":
    sys.exit(main())
