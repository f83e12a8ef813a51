"""Calls that follow other work of a CUDA stream."""

import time

import torch


def submit_behind_work(source, target, submit, check):
    """Yields the seconds until a call returned and until it was checked, for torch's stream and for a new one.

    Each stream works for about a second, and then copies `source` to `target`, which is not a number before.
    submit(stream) submits a call that reads `target`, and check(ticket) takes and compares its results.
    """
    busy = torch.randn(8192, 8192, device="cuda")
    for stream in (None, torch.cuda.Stream()):
        target.fill_(float("nan"))
        torch.cuda.synchronize()
        with torch.cuda.stream(stream or torch.cuda.current_stream()):
            for _ in range(40):
                busy = (busy @ busy).clamp(-1, 1)
            target.copy_(source)
            start = time.perf_counter()
            ticket = submit(stream)
            submitted = time.perf_counter() - start
            check(ticket)
        yield submitted, time.perf_counter() - start
