"""One PDF page of lines in millimetres, on layers (optional content groups, ISO 32000-1, 8.11)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

POINT = 72.0 / 25.4
"""Points a millimetre."""


def pdf_page(
    width: float,
    height: float,
    layers: Sequence[tuple[str, tuple[float, float, float], Sequence[NDArray[np.float64]]]],
    line_width: float,
    title: str,
) -> bytes:
    """The file: a page of ``width`` by ``height`` mm with layers of a name, a colour (0 to 1), and polylines.

    Polylines are (N, 2) millimetres from the upper left corner, y downwards; one that ends where it begins is
    closed. No layout program in between: what is 10 mm here is 10 mm on paper, unless the printer scales.
    """
    first = 5  # objects 1 to 4: catalog, pages, page, content
    groups = [f"{first + k} 0 R" for k in range(len(layers))]
    properties = " ".join(f"/L{k} {group}" for k, group in enumerate(groups))
    content = _content(height, layers, line_width)
    listed = " ".join(groups)
    objects = [
        f"<< /Type /Catalog /Pages 2 0 R /OCProperties << /OCGs [{listed}] /D << /Order [{listed}] /ON [{listed}] >> >>"
        " /ViewerPreferences << /PrintScaling /None >> >>",
        "<< /Type /Pages /Kids [3 0 R] /Count 1 >>",
        f"<< /Type /Page /Parent 2 0 R /MediaBox [0 0 {_number(width * POINT)} {_number(height * POINT)}]"
        f" /Resources << /Properties << {properties} >> >> /Contents 4 0 R >>",
        f"<< /Length {len(content)} >>\nstream\n{content}\nendstream",
        *(f"<< /Type /OCG /Name {_text(name)} >>" for name, _, _ in layers),
        f"<< /Title {_text(title)} /Producer (origami-lab) >>",
    ]
    out = b"%PDF-1.5\n%\xe2\xe3\xcf\xd3\n"
    offsets = []
    for number, body in enumerate(objects, start=1):
        offsets.append(len(out))
        out += f"{number} 0 obj\n{body}\nendobj\n".encode("ascii")
    table = len(out)
    rows = "".join(f"{offset:010d} 00000 n \n" for offset in offsets)
    size = len(objects) + 1
    out += f"xref\n0 {size}\n0000000000 65535 f \n{rows}".encode("ascii")
    out += f"trailer\n<< /Size {size} /Root 1 0 R /Info {size - 1} 0 R >>\nstartxref\n{table}\n%%EOF\n".encode("ascii")
    return out


def _content(
    height: float,
    layers: Sequence[tuple[str, tuple[float, float, float], Sequence[NDArray[np.float64]]]],
    line_width: float,
) -> str:
    """The drawing: the page's y runs upwards."""
    parts = [f"{_number(line_width * POINT)} w 1 J 1 j"]
    for k, (_, colour, lines) in enumerate(layers):
        parts += [f"/OC /L{k} BDC", " ".join(_number(part) for part in colour) + " RG"]
        for line in lines:
            closed = len(line) > 2 and np.array_equal(line[0], line[-1])
            places = [f"{_number(x * POINT)} {_number((height - y) * POINT)}" for x, y in line]
            steps = [f"{place} l" for place in (places[1:-1] if closed else places[1:])]
            parts.append(" ".join([f"{places[0]} m", *steps, "s" if closed else "S"]))
        parts.append("EMC")
    return "\n".join(parts)


def _number(value: float) -> str:
    """PDF has no exponents."""
    return f"{value:.5f}".rstrip("0").rstrip(".")


def _text(text: str) -> str:
    """A text string, UTF-16 in hexadecimal: it needs no escapes."""
    return "<feff" + text.encode("utf-16-be", "replace").hex() + ">"
