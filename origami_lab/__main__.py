"""`python -m origami_lab` is `origami-lab`."""

from origami_lab.cli import main

if __name__ == "__main__":
    raise SystemExit(main())
