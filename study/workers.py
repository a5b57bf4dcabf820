"""Pieces of work on all cores or on a Dask cluster, in processes that were started anew.

Workers compute and one process gathers, so that results do not depend on who computed them, on how
many there were or in which order they finished: each piece says itself which one it is.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import CancelledError
from typing import Any, TypeVar

from study.errors import StudyError

RETRIES = 5
"""How often a piece is given to another worker of a cluster after its own died."""

Result = TypeVar("Result")
Arguments = tuple[Any, ...]


def checked_jobs(jobs: int) -> int:
    """Return a number of processes.

    Raises:
        StudyError: it is 0.
    """
    if jobs == 0:
        raise StudyError("0 processes", "Give --jobs 1 or more, or -1 for all cores.")
    return jobs


def run_pieces(
    function: Callable[..., Result],
    pieces: Sequence[Arguments],
    *,
    jobs: int = -1,
    scheduler: str = "",
    what: str = "piece of work",
    again: str = "Run the command again.",
) -> Iterator[Result]:
    """Call a function with each tuple of arguments; yield the results as they come.

    Args:
        function: of a module, so that a worker can import it.
        pieces: arguments of each call.
        jobs: processes at once on this machine; -1 for one a core.
        scheduler: address of a Dask cluster's scheduler to use instead.
        what: a piece in words.
        again: what running the command again does, a sentence.

    Raises:
        StudyError: a worker was ended from outside, or the cluster cannot be used.
    """
    if scheduler:
        yield from _on_cluster(function, pieces, scheduler, what, again)
    else:
        yield from _on_cores(function, pieces, jobs, again)


def _on_cores(
    function: Callable[..., Result], pieces: Sequence[Arguments], jobs: int, again: str
) -> Iterator[Result]:
    from joblib import Parallel, delayed, parallel_config  # noqa: PLC0415
    from joblib.externals.loky.process_executor import TerminatedWorkerError  # noqa: PLC0415

    tasks = (delayed(function)(*arguments) for arguments in pieces)
    try:
        with parallel_config(backend="loky", inner_max_num_threads=1):
            parallel = Parallel(
                n_jobs=jobs, return_as="generator_unordered", batch_size=1, pre_dispatch="2*n_jobs"
            )
            yield from parallel(tasks)
    except TerminatedWorkerError as error:
        raise StudyError(
            "a worker process was ended from outside, or ran out of memory",
            f"{again} --jobs runs fewer at once.",
        ) from error


def _on_cluster(
    function: Callable[..., Result],
    pieces: Sequence[Arguments],
    address: str,
    what: str,
    again: str,
) -> Iterator[Result]:
    try:
        import distributed  # noqa: PLC0415
        from distributed.scheduler import KilledWorker  # noqa: PLC0415
    except ImportError as error:
        raise StudyError(
            "a Dask cluster needs the packages dask and distributed",
            'Install the extra: pip install "scaled-autonomy[cluster]".',
        ) from error
    cluster: Any = distributed
    try:
        client: Any = cluster.Client(address, timeout="10s", set_as_default=False)
    except (OSError, ValueError, TimeoutError) as error:
        raise StudyError(
            f"no Dask scheduler answers at {address}: {error}",
            "Start one with dask scheduler, and give its address, such as tcp://host:8786.",
        ) from error
    with client:
        if not client.scheduler_info(n_workers=-1).get("workers"):
            raise StudyError(
                f"the Dask cluster at {address} has no workers",
                f"Start some: dask worker {address} --nthreads 1",
            )
        futures = [
            client.submit(function, *arguments, pure=False, retries=RETRIES) for arguments in pieces
        ]
        try:
            for future in cluster.as_completed(futures, loop=client.loop):
                finished: Result = future.result()
                yield finished
        except KilledWorker as error:
            raise StudyError(
                f"the cluster's workers died again and again on one {what}",
                f"Look at their memory. {again}",
            ) from error
        except (ImportError, RuntimeError) as error:
            raise StudyError(
                f"the cluster's workers cannot run a {what}: {str(error).splitlines()[0]}",
                "Install the same version of the program on every machine.",
            ) from error
        except (CancelledError, OSError) as error:
            raise StudyError(
                f"the connection to the Dask scheduler at {address} was lost", again
            ) from error
