"""The program ``gearbow`` as ``python -m gearbow``."""

from gearbow.cli.main import main

if __name__ == "__main__":
    main()
