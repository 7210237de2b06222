"""Run the command line with ``python -m elastomorph``."""

from elastomorph.cli import main

if __name__ == "__main__":
    main()
