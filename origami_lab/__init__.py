"""origami-lab: search for crease patterns that fold rigidly, with one degree of freedom, into a shape.

``origami_lab.run([...])`` does what the command does and ``origami_lab.load(DIR)`` reads a finished run; both return
a :class:`Result`. ``origami_lab.export_design(...)`` writes a design in other formats, ``origami_lab.show(...)`` shows
one in a notebook, ``origami_lab.verify(FILE)`` returns its :class:`Certificate`. They are imported when first used, so
that ``import origami_lab`` costs nothing.
"""

import lazy_loader

from origami_lab.about import __version__ as __version__

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
