"""Videos as cameras leave them: folders of PNG or TIFF images, TIFF stacks, mp4 and avi files.

Images are read by Pillow, videos by PyAV (the extra `video`), a frame at a time. Frames are [row, column], their
rows run downwards, and colours become grey. A folder is sorted by the numbers in the names of its files.
"""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from leakref._base import FloatArray, LeakrefError, installed_with
from leakref.cubes.deferred import Deferred
from leakref.cubes.suspicion import refuse, told

__all__ = ["Frames", "frames"]

_IMAGES = {".png", ".tif", ".tiff"}
_VIDEOS = {".mp4", ".avi", ".mov", ".mkv", ".m4v", ".mpg"}


@dataclass(frozen=True)
class Frames:
    """The frames of a video: `samples` (nt, ny, nx), not yet read, and what is known of their times.

    `stamps` (nt,) are seconds, None where the images have none. `notes` say what is done to the samples.
    """

    samples: Deferred
    stamps: FloatArray | None
    notes: tuple[str, ...]


def frames(path: Path) -> Frames | None:
    """The frames of a folder of images, a TIFF stack or a video, None if `path` is none of these.

    Raises LeakrefError for a folder without images or with images of several sizes, for a video that cannot be decoded,
    and where the library for it is lacking.
    """
    with told(path):
        if path.is_dir():
            return _folder(path)
        if not path.is_file():
            return None
        with path.open("rb") as stream:
            start = stream.read(12)
        if start[:4] in (b"II*\0", b"MM\0*", b"II+\0", b"MM\0+"):
            return _stack(path)
        if start.startswith(b"\x89PNG"):
            refuse(path, "is a single image", "name the folder with all images of the video")
        if start[4:8] == b"ftyp" or start.startswith(b"RIFF") or (path.suffix.lower() in _VIDEOS and start):
            return _video(path)
        return None


def _number(path: Path) -> list[tuple[int, str]]:
    """A name for sorting: frame 10 comes after frame 9.

    Runs of digits count as numbers and all else as letters, as people read names of files.
    """
    return [(int(part), "") if part.isdigit() else (-1, part) for part in re.split(r"(\d+)", path.name)]


def _grey(image: Any) -> tuple[Any, bool]:
    """An image as an array [row, column], and whether colours were averaged to grey.

    Grey images keep their type, uint8, uint16 or float32: nothing is scaled. Of colours the plain mean of red, green
    and blue is taken, rounded, since no weighting is right for water; transparency is dropped.
    """
    if image.mode in ("P", "RGB", "RGBA", "LA", "CMYK", "YCbCr", "PA"):
        colours = np.asarray(image.convert("RGB"), dtype=np.uint8)
        return np.rint(colours.mean(axis=2)).astype(np.uint8), bool(np.ptp(colours, axis=2).any())
    if image.mode == "1":
        return np.asarray(image.convert("L")), False
    return np.asarray(image), False


def _opened(path: Path) -> Any:
    """An image or a stack of them, not yet decoded; more pixels than Pillow thinks safe are refused."""
    from PIL import Image

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", Image.DecompressionBombWarning)
            return Image.open(path, formats=["PNG", "TIFF"])
    except (OSError, SyntaxError, ValueError, Image.DecompressionBombWarning, Image.DecompressionBombError) as error:
        refuse(path, f"is no image that can be read ({error or type(error).__name__})", "copy or export it again")


def _decoded(path: Path, image: Any) -> tuple[Any, bool]:
    """As `_grey`, with a refusal that names the file where an image is damaged."""
    try:
        return _grey(image)
    except (OSError, SyntaxError, ValueError, EOFError) as error:
        refuse(path, f"is damaged or cut short ({error or type(error).__name__})", "copy or export it again")


def _folder(path: Path) -> Frames:
    """The images in a folder, all of the same kind, in the order of their numbers."""
    kinds = {suffix: [p for p in path.iterdir() if p.suffix.lower() == suffix] for suffix in sorted(_IMAGES)}
    files = sorted((p for found in kinds.values() for p in found), key=_number)
    if not files:
        refuse(
            path, "is a folder without images", "name the file with the cube in it, or a folder of PNG or TIFF images"
        )
    if sum(map(bool, kinds.values())) > 1:
        counts = ", ".join(f"{len(found)} {suffix}" for suffix, found in kinds.items() if found)
        refuse(path, f"holds images of several kinds ({counts})", "leave those of one video in it")
    with _opened(files[0]) as image:
        first, coloured = _decoded(files[0], image)

    def blocks(cut: tuple[slice, ...]) -> Iterator[Any]:
        for file in files[cut[0]]:
            with _opened(file) as image:
                frame, _ = _decoded(file, image)
            if frame.shape != first.shape or frame.dtype != first.dtype:
                refuse(
                    file,
                    f"is of {frame.shape[1]} x {frame.shape[0]} pixels of {frame.dtype}, the first image of "
                    f"{first.shape[1]} x {first.shape[0]} of {first.dtype}",
                    "leave the images of one video in the folder",
                )
            yield frame[cut[1:]][None]

    samples = Deferred((len(files), *first.shape), first.dtype, blocks)
    return Frames(samples, None, (f"{len(files)} images, {files[0].name} to {files[-1].name}", *_colour_note(coloured)))


def _colour_note(coloured: bool) -> Sequence[str]:
    return ["colours were averaged to grey"] if coloured else []


def _stack(path: Path) -> Frames:
    """The pages of a TIFF file, which must all be of one size."""
    with _opened(path) as image:
        count = getattr(image, "n_frames", 1)
        first, coloured = _decoded(path, image)

    def blocks(cut: tuple[slice, ...]) -> Iterator[Any]:
        with _opened(path) as image:
            for page in range(*cut[0].indices(count)):
                image.seek(page)
                frame, _ = _decoded(path, image)
                if frame.shape != first.shape:
                    refuse(path, f"has page {page} of shape {frame.shape}, the first {first.shape}", "export it again")
                yield frame[cut[1:]][None]

    notes = (f"a stack of {count} pages", *_colour_note(coloured))
    return Frames(Deferred((count, *first.shape), first.dtype, blocks), None, notes)


def _video(path: Path) -> Frames:
    """The frames of the first video stream of a file, in the brightness that it stores (luma).

    Frames are counted by their packets, without decoding, and their times are those of the packets in the order in
    which they are shown. Decoding goes through the file once, from its beginning, and ends with the last frame that is
    wanted.
    """
    try:
        import av
    except ModuleNotFoundError:
        raise LeakrefError(
            "extract", f"{path} is a video, and PyAV is not installed", f"{installed_with('video')}, or extract images"
        ) from None
    try:
        with av.open(str(path)) as container:
            stream = container.streams.video[0]
            base = float(stream.time_base or 0)
            ticks = sorted(packet.pts for packet in container.demux(stream) if packet.size and packet.pts is not None)
            shape = (len(ticks), stream.height, stream.width)
            rate = float(stream.average_rate or 0)
    except (av.FFmpegError, IndexError) as error:
        refuse(path, f"is no video that can be read ({error})", "copy it again, or extract images")
    if not ticks:
        refuse(path, "holds no frames", "copy it again")

    def blocks(cut: tuple[slice, ...]) -> Iterator[Any]:
        wanted = set(range(*cut[0].indices(shape[0])))
        try:
            with av.open(str(path)) as container:
                for n, frame in enumerate(container.decode(video=0)):
                    if n in wanted:
                        wanted.discard(n)
                        yield frame.to_ndarray(format="gray")[cut[1:]][None]
                    if not wanted:
                        break
        except av.FFmpegError as error:
            refuse(path, f"is damaged at frame {shape[0] - len(wanted)} ({error})", "copy it again, or use --frames")
        if wanted:
            refuse(path, f"holds {len(wanted)} frames fewer than it says", "copy it again, or pass --frames")

    stamps = np.array(ticks) * base if base else np.arange(len(ticks)) / rate if rate else None
    notes = (f"a video of {shape[0]} frames at {rate:.6g} a second", "the brightness (luma) of its colours was taken")
    return Frames(Deferred(shape, np.dtype(np.uint8), blocks), stamps, notes)
