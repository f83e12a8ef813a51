"""Renders a data set on a Ray cluster::

    python -m latelight.ray job.yaml --address auto --shards 64

The job's shards are tasks of the cluster, with a GPU each, or only processors if the cluster has no GPU. Ray runs the
shards of nodes that fail again on other nodes, where they resume. The set's folder must be on a file system that all
nodes share, and the program ``latelight`` on each node's PATH. The set has the same bytes as by ``latelight batch``.

Options other than those below are those of ``latelight batch``. Requires the package ``ray``.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import shutil
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

# Exit codes of the program (docs/exit-codes.md).
_OK, _USAGE, _SOME_FRAMES_FAILED = 0, 2, 6
_FINAL = (_OK, _USAGE, 3, _SOME_FRAMES_FAILED)  # a repetition would end alike; 3: bad input
_BUSY = "another process is working on"
_SECONDS_TO_WAIT = 60  # for the process of a node that is considered dead to end
_SHARDS_PER_SLOT = 4  # more than one, so that fast nodes can do more


class ShardResult(NamedTuple):
    """The end of a shard: its exit code, the machine, and what it wrote to standard error."""

    code: int
    host: str
    message: str


class JobError(Exception):
    """Ends the program with an exit code and a sentence."""

    def __init__(self, code: int, message: str) -> None:
        super().__init__(message)
        self.code = code


# --- on the nodes ----------------------------------------------------------------------------------------------------
#
# These functions are copied to the nodes, which therefore need no Python package other than Ray.


def _end_with_parent() -> None:
    """Has Linux terminate this process with the worker that started it, because a repetition may run elsewhere."""
    import ctypes

    ctypes.CDLL(None).prctl(1, signal.SIGTERM)  # PR_SET_PDEATHSIG


def _run_once(command: Sequence[str], folder: str, environment: dict[str, str]) -> tuple[int, str]:
    process = subprocess.Popen(
        command,
        cwd=folder,
        env={**os.environ, **environment},
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        errors="replace",
        preexec_fn=_end_with_parent,
    )
    try:
        message = process.communicate()[1]
    finally:  # the task was canceled
        if process.poll() is None:
            process.terminate()
            process.wait()
    return process.returncode, message.strip()


def _run_shard(program: str | None, arguments: list[str], folder: str, environment: dict[str, str]) -> ShardResult:
    """Runs a shard. Raises RuntimeError if Ray should run it again: a lost device, a signal, memory that ran out."""
    host = socket.gethostname()
    found = program or os.environ.get("LATELIGHT_PROGRAM") or shutil.which("latelight")
    if not found or not os.path.isdir(folder):
        what = f"the folder '{folder}' is missing" if found else "the program latelight is not on the PATH"
        return ShardResult(_USAGE, host, f"{what} of the node {host}; --program names another")
    limit = time.monotonic() + _SECONDS_TO_WAIT
    code, message = _run_once([found, *arguments], folder, environment)
    while code == _USAGE and _BUSY in message and time.monotonic() < limit:
        time.sleep(1)
        code, message = _run_once([found, *arguments], folder, environment)
    if code not in _FINAL:
        raise RuntimeError(f"a shard ended with code {code} on {host}: {message}")
    return ShardResult(code, host, message)


# --- progress --------------------------------------------------------------------------------------------------------


class Progress:
    """Follows the logs in the set's folder, which all nodes write, and prints lines to standard error."""

    def __init__(self, folder: Path, shards: int, seconds: float = 10) -> None:
        self._state = folder / ".latelight"
        self._shards = shards
        self._seconds = seconds
        self._printed, self._line = 0.0, ""
        self._counts: dict[Path, tuple[int, int, int]] = {}  # of a shard's log: file number, bytes, frames
        self._log_bytes = self._size(self._state / "log")
        self._inline = sys.stderr.isatty()

    @staticmethod
    def _size(path: Path) -> int:
        with contextlib.suppress(OSError):
            return path.stat().st_size
        return 0

    def _frames_in(self, path: Path) -> int:
        """The finished frames of a shard's log, of which only new lines are read."""
        with contextlib.suppress(OSError), path.open("rb") as file:
            number = os.fstat(file.fileno()).st_ino
            known, begin, frames = self._counts.get(path, (number, 0, 0))
            if known != number:
                begin = frames = 0  # the shard was started again
            file.seek(begin)
            new = file.read()
            new = new[: new.rfind(b"\n") + 1]
            frames += sum(line.startswith(b'{"frame"') for line in new.split(b"\n"))
            self._counts[path] = (number, begin + len(new), frames)
        return self._counts.get(path, (0, 0, 0))[2]

    def _planned(self) -> int:
        with contextlib.suppress(OSError, ValueError):
            return int(json.loads((self._state / "plan.json").read_text()).get("frames", 0))
        return 0

    def _events(self) -> Iterator[str]:
        """New lines of the log of all nodes, such as "node-3: shard 2-of-8 begins: 10 of 10 frames ..."."""
        with contextlib.suppress(OSError), (self._state / "log").open(errors="replace") as file:
            file.seek(self._log_bytes)
            for line in file.read().splitlines(keepends=True):
                if not line.endswith("\n"):
                    break
                self._log_bytes += len(line.encode())
                words = line.split(maxsplit=3)
                if len(words) == 4:
                    yield f"{words[1]}: {words[3].strip()}"

    def show(self, finished: int, last: bool = False) -> None:
        for event in self._events():
            self._print(event)
        frames = sum(self._frames_in(self._state / f"shard-{i}-of-{self._shards}.jsonl") for i in range(self._shards))
        if (planned := self._planned()) == 0 or (last and frames == 0):
            return
        line = f"{frames} of {planned} frames, {finished} of {self._shards} shards"
        now = time.monotonic()
        if line == self._line or (not last and not self._inline and now - self._printed < self._seconds):
            return
        self._printed, self._line = now, line
        self._print(line, "\r" if self._inline and not last else "\n")

    def _print(self, text: str, end: str = "\n") -> None:
        clear = "\033[K" if self._inline else ""
        print(f"latelight.ray: {text}{clear}", end=end, file=sys.stderr, flush=True)


# --- the job ---------------------------------------------------------------------------------------------------------


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m latelight.ray",
        usage="%(prog)s [JOB] [options]",
        allow_abbrev=False,
        description="Renders a data set on a Ray cluster. Other options are those of latelight batch.",
    )
    parser.add_argument("-o", "--output", help="folder of the data set, on a file system that all nodes share")
    parser.add_argument("--resume", action="store_true", help="complete an existing set")
    parser.add_argument("--address", default="auto", help='Ray cluster, or "local" for this machine (default: auto)')
    parser.add_argument(
        "--shards", type=int, help="number of tasks (default: 4 per GPU, or per processor without GPUs)"
    )
    parser.add_argument("--cpus", type=float, default=1, help="processors that a task reserves (default: 1)")
    parser.add_argument("--gpus", type=float, help="GPUs that a task reserves (default: 1 if the cluster has any)")
    parser.add_argument("--retries", type=int, default=3, help="times that a failed task is run again (default: 3)")
    parser.add_argument("--program", help="path of the program on all nodes (default: latelight on the PATH)")
    return parser


def _folder_of(options: argparse.Namespace) -> Path:
    if options.output:
        return Path(options.output)
    if not options.job:
        raise JobError(_USAGE, "a job requires a folder for its files: add -o FOLDER")
    import yaml  # a dependency of Ray; JSON is YAML, too

    try:
        job = yaml.safe_load(Path(options.job).read_text(encoding="utf-8"))
    except (OSError, ValueError, yaml.YAMLError) as error:
        raise JobError(3, f"can't read '{options.job}': {' '.join(str(error).split())}") from None
    output = job.get("output") if isinstance(job, dict) else None
    if not isinstance(output, str):
        raise JobError(_USAGE, f"{options.job} lacks the key output; add it, or -o FOLDER")
    return Path(output)


def _check(options: argparse.Namespace, others: list[str], folder: Path) -> None:
    for option in ("--shard", "--slurm", "--dry-run"):
        if any(other == option or other.startswith(option + "=") for other in others):
            raise JobError(_USAGE, f"latelight.ray doesn't support {option}; use latelight batch")
    if options.shards is not None and not 1 <= options.shards <= 1_000_000:
        raise JobError(_USAGE, f"--shards takes a number from 1 to 1000000, not {options.shards}")
    if options.retries < 0 or options.cpus < 0 or (options.gpus is not None and options.gpus < 0):
        raise JobError(_USAGE, "--retries, --cpus and --gpus take numbers from 0")
    if not options.resume and ((folder / ".latelight").exists() or (folder / "manifest.json").exists()):
        raise JobError(
            _USAGE, f"'{folder}' already contains a data set: add --resume to complete it, or choose another folder"
        )


def _resources(options: argparse.Namespace, cluster: dict[str, float]) -> tuple[float, int]:
    """GPUs per task, and the number of shards."""
    gpus = options.gpus if options.gpus is not None else float(cluster.get("GPU", 0) >= 1)
    slots = cluster.get("GPU", 0) / gpus if gpus > 0 else cluster.get("CPU", 1) / max(options.cpus, 1)
    return gpus, options.shards or max(1, int(slots)) * _SHARDS_PER_SLOT


def _wait(ray: Any, tasks: list[Any], progress: Progress) -> list[ShardResult]:
    results: list[ShardResult] = []
    waiting = list(tasks)
    while waiting:
        done, waiting = ray.wait(waiting, timeout=1)
        for task in done:
            try:
                results.append(ray.get(task))
            except ray.exceptions.RayError as error:
                cause = getattr(error, "cause", None) or error
                raise JobError(1, f"a shard failed after all retries: {cause}") from None
            if results[-1].code in (_USAGE, 3):
                raise JobError(results[-1].code, results[-1].message.removeprefix("latelight: "))
        progress.show(len(results))
    return results


def _merge(options: argparse.Namespace, folder: Path) -> None:
    """The last shard merges the set; this completes a merge that was interrupted."""
    if (folder / "manifest.json").exists() and not list((folder / ".latelight").glob("shard-*.jsonl")):
        return
    program = options.program or os.environ.get("LATELIGHT_PROGRAM") or shutil.which("latelight")
    if not program:
        raise JobError(_USAGE, f"'{folder}' is not merged: run latelight batch merge on a node")
    code, message = _run_once([program, "batch", "merge", str(folder)], os.getcwd(), {})
    if code != _OK:
        raise JobError(code if code > 0 else 1, message.removeprefix("latelight: "))


def run(arguments: Sequence[str] | None = None) -> int:
    """Runs a job and returns the program's exit code. Raises JobError for errors that end the job."""
    arguments = list(sys.argv[1:] if arguments is None else arguments)
    # argparse would take the value of an option that it does not know for the job.
    job = arguments.pop(0) if arguments and not arguments[0].startswith("-") else None
    options, others = _parser().parse_known_args(arguments)
    options.job = job
    folder = _folder_of(options)
    _check(options, others, folder)
    try:
        import ray
    except ImportError:
        raise JobError(_USAGE, "latelight.ray requires the package ray: pip install 'ray[default]'") from None
    if not ray.is_initialized():
        try:
            ray.init(address=options.address, log_to_driver=False, logging_level="ERROR")
        except (ConnectionError, ValueError) as error:
            raise JobError(
                _USAGE,
                f'there is no Ray cluster at "{options.address}" ({error}); start one with '
                "ray start --head, or use --address local",
            ) from None
    gpus, shards = _resources(options, ray.cluster_resources())
    command = ["batch", *([options.job] if options.job else []), *others, "-o", str(folder), "--resume"]
    environment = {} if gpus > 0 else {"LATELIGHT_THREADS": str(max(1, int(options.cpus)))}
    run_shard = ray.remote(
        num_gpus=gpus,
        num_cpus=options.cpus,
        max_retries=options.retries,
        retry_exceptions=True,
        scheduling_strategy="SPREAD",
    )(_run_shard)
    progress = Progress(folder, shards)
    tasks = [
        run_shard.remote(options.program, [*command, "--shard", f"{i}/{shards}"], os.getcwd(), environment)
        for i in range(shards)
    ]
    try:
        results = _wait(ray, tasks, progress)
    except BaseException:
        for task in tasks:
            ray.cancel(task)
        raise
    progress.show(shards, last=True)
    failed = [result for result in results if result.code != _OK]
    for result in failed:
        print(f"latelight.ray: {result.host}: {result.message.removeprefix('latelight: ')}", file=sys.stderr)
    if failed:
        return _SOME_FRAMES_FAILED
    _merge(options, folder)
    return _OK


def main() -> None:
    try:
        sys.exit(run())
    except JobError as error:
        print(f"latelight.ray: {error}", file=sys.stderr)
        sys.exit(error.code)
    except KeyboardInterrupt:
        sys.exit(_SOME_FRAMES_FAILED)


if __name__ == "__main__":
    main()
