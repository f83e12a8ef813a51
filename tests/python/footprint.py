"""What a process holds, and what of it grew: for tests of processes that live long."""

import ctypes
import gc
import os
import statistics
from dataclasses import dataclass, fields
from pathlib import Path


class Mallinfo2(ctypes.Structure):
    names = "arena ordblks smblks hblks hblkhd usmblks fsmblks uordblks fordblks keepcost"
    _fields_ = [(name, ctypes.c_size_t) for name in names.split()]


libc = ctypes.CDLL(None)
libc.mallinfo2.restype = Mallinfo2


@dataclass
class Footprint:
    heap: int  # bytes that are allocated and not freed; 0 for other processes. Lavapipe's Vulkan objects are among them.
    resident: int  # bytes; of this process after the heap's free memory was returned
    threads: int
    descriptors: int
    mappings: int  # ranges of the address space
    files: int  # in the cache folder

    def __str__(self):
        return ", ".join(f"{field.name} {getattr(self, field.name):,}" for field in fields(self))


def footprint(process="self"):
    heap = 0
    if process == "self":
        gc.collect()
        info = libc.mallinfo2()
        heap = info.uordblks + info.hblkhd
        libc.malloc_trim(0)
    caches = Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache")) / "latelight"
    folder = Path(f"/proc/{process}")
    return Footprint(
        heap=heap,
        resident=int((folder / "statm").read_text().split()[1]) * 4096,
        threads=len(os.listdir(folder / "task")),
        descriptors=len(os.listdir(folder / "fd")),
        mappings=(folder / "maps").read_text().count("\n"),
        files=sum(1 for _ in caches.rglob("*")),
    )


def growth_per_epoch(footprints):
    """Bytes of heap: the slope between the medians of the first and the last third, so that single peaks don't count."""
    third = max(len(footprints) // 3, 1)
    first, last = (statistics.median(f.heap for f in part) for part in (footprints[:third], footprints[-third:]))
    return (last - first) / (len(footprints) - third)


def check(footprints, operations):
    """Sentences about what grew in epochs of so many operations. Early ones, which fill caches, must be left out."""
    half = len(footprints) // 2
    most = lambda part, name: max(getattr(f, name) for f in part)
    for name, factor, more in (
        ("threads", 1, 0),
        ("descriptors", 1, 0),
        ("files", 1, 0),
        ("mappings", 1, 60),
        ("resident", 1.15, 0),
    ):
        early, late = most(footprints[:half], name), most(footprints[half:], name)
        if late > early * factor + more:
            yield f"{name} grew from {early:,} to {late:,}"
    growth = growth_per_epoch(footprints)
    if growth > 16 * operations:  # a leak of the heap's smallest block, 32 bytes, in every second operation
        yield f"the heap grows by {growth:,.0f} bytes per {operations} operations"
