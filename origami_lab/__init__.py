"""origami-lab: search for crease patterns that fold rigidly, with one degree of freedom, into a shape."""

__version__ = "0.1.0"
