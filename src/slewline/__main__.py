"""`python -m slewline` is the command `slewline`."""

from .cli.main import main

if __name__ == "__main__":
    main()
