"""`python -m uwopt` is the command `uwopt`."""

from uwopt.cli.start import start

if __name__ == "__main__":
    start()
