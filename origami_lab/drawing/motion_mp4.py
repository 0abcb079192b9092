"""The folding motion as a film, made by ffmpeg."""

from __future__ import annotations

import os
import shutil
import subprocess

from origami_lab.drawing.motion_gif import BEST_SHOWN, FLAT_SHOWN, STEP_SHOWN, motion_pictures
from origami_lab.drawing.scene import TargetSurface
from origami_lab.errors import InputError
from origami_lab.files import replacing
from origami_lab.fold_format.fold_file import FoldFile
from origami_lab.text import one_line


def draw_movie(
    fold: FoldFile, path: str | os.PathLike[str], target: TargetSurface | None = None, *, size: int = 720
) -> None:
    """An MP4, ``size`` pixels wide, of the motion from flat to the best driving angle and back, as in the GIF.

    Raises :class:`InputError` where there is no ffmpeg, or it makes no film.
    """
    program = shutil.which("ffmpeg")
    if program is None:
        raise InputError("to", "mp4", "needs ffmpeg, which is not on the PATH; gif needs nothing")
    pictures = motion_pictures(fold, target, size)
    held = [1] * len(pictures)
    held[0], held[-1] = (round(shown / STEP_SHOWN) for shown in (FLAT_SHOWN, BEST_SHOWN))
    frames = [picture for picture, count in zip(pictures, held, strict=True) for _ in range(count)]
    frames += pictures[-2:0:-1]
    command = [program, "-hide_banner", "-loglevel", "error", "-nostdin", "-y", "-f", "rawvideo", "-pix_fmt", "rgb24"]
    command += ["-s", f"{frames[0].width}x{frames[0].height}", "-r", f"1000/{STEP_SHOWN}", "-i", "pipe:0"]
    # players want sides of even length and this pixel format
    command += ["-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2:color=white", "-pix_fmt", "yuv420p", "-movflags", "+faststart"]
    with replacing(path) as part:
        done = subprocess.run(
            [*command, "-f", "mp4", str(part)],
            input=b"".join(frame.convert("RGB").tobytes() for frame in frames),
            capture_output=True,
            check=False,
        )
        if done.returncode:
            said = done.stderr.decode(errors="replace").strip() or f"exit code {done.returncode}"
            raise InputError("to", "mp4", f"ffmpeg made no film: {one_line(said)[:200]}")
