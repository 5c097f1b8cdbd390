"""The program `roughcontact`, also as `python -m roughcontact.interface` where it is not installed."""

import sys


def main() -> int:
    """Run the program; return its exit code, that of an interruption also while its modules are imported."""
    try:
        from roughcontact.interface import program

        return program.main()
    except KeyboardInterrupt:
        print("roughcontact: interrupted", file=sys.stderr)
        return 130


if __name__ == "__main__":
    sys.exit(main())
