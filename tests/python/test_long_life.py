"""A process that lives long holds no more than before (long_life.py, which runs alone for hours)."""

import os

import latelight
import pytest

import long_life
from footprint import Footprint, check


def test_holds_no_more_than_before(device):
    if os.environ.get("LATELIGHT_TEST_ALL", "0") in ("", "0"):
        pytest.skip("left to ./dev test --all")
    footprints, counts = long_life.live(40, device)
    assert counts.total() == 40 * long_life.OPERATIONS
    assert list(check(footprints[8:], long_life.OPERATIONS)) == []


def footprints_of(*heaps, threads=3):
    return [Footprint(heap, 10**8, threads, 6, 400, 2) for heap in heaps]


def test_check_finds_what_grows():
    level = footprints_of(*[10**7, 10**7 + 3000] * 6)
    assert list(check(level, 250)) == []
    leak = footprints_of(*range(10**7, 10**7 + 12 * 8000, 8000))
    assert list(check(leak, 250)) == ["the heap grows by 8,000 bytes per 250 operations"]
    peak = footprints_of(*[10**7] * 11, 10**8)
    assert list(check(peak, 250)) == []
    threads = footprints_of(*[10**7] * 6) + footprints_of(*[10**7] * 6, threads=4)
    assert list(check(threads, 250)) == ["threads grew from 3 to 4"]


def test_a_short_life(device):
    life = long_life.Life("builtin:boxes", device, 1, long_life.Counter())
    life.choices = [{"raster": "hardware", "shadows": "none", "outputs": ["rgba", "depth"]}]
    for _ in range(150):
        life.act()
    assert isinstance(life.renderer, latelight.Renderer)
    assert life.renderer.validation_messages() == []
