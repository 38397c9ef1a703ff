"""A child process that does not outlive its parent, however that ends."""

import multiprocessing
import os
import threading


def end_with_parent() -> None:
    """Call it in a process of a pool: it ends, at once, when the process that made it is gone.

    A pool's process waits for its next task on a pipe whose other end it holds itself: if its parent is
    killed, it would wait for ever.
    """
    parent = multiprocessing.parent_process()
    assert parent is not None, "this is no child process"

    def wait() -> None:
        parent.join()
        os._exit(0)

    threading.Thread(target=wait, name="parent's end", daemon=True).start()
