"""`python -m uwopt` is the command `uwopt`."""

from uwopt.cli.app import main

if __name__ == "__main__":
    main()
