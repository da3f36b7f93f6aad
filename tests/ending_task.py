"""A task that ends its process; in a file of its own, for each new process imports it."""

import os
import signal


def dies(task, folder):
    """What it was given; task 1 ends its process each time, task 2 once."""
    mark = os.path.join(folder, "died")
    if task == 1 or task == 2 and not os.path.exists(mark):
        open(mark, "w").close()
        os.kill(os.getpid(), signal.SIGKILL)
    return task
