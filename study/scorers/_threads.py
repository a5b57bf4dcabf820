"""How torch is used: on one thread, and loaded before anybody waits for it."""

from __future__ import annotations


def use_one_thread() -> None:
    """Keep torch to one thread: faster at this size, and the same numbers every time."""
    import torch  # noqa: PLC0415 - slow to import, and needed by fits only

    torch.set_num_threads(1)


def warm_up() -> None:
    """Load what a first fit would load: torch, and what its optimisers import when made."""
    import torch  # noqa: PLC0415

    use_one_thread()
    torch.optim.AdamW([torch.zeros(1, requires_grad=True)])
