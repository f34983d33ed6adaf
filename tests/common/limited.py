"""Commands that may take only so long."""

import os
import shlex
import signal
import subprocess


class Overdue(AssertionError):
    """A command took too long, and was ended. `said`: what it had written to standard output."""

    def __init__(self, command, limit, said):
        super().__init__(f"took longer than {limit} s: {shlex.join(map(str, command))}\n{said or ''}")
        self.said = said


def run(command, limit, **options):
    """As `subprocess.run` with `limit` [s] and `text=True`, but ends all that the command has started, too.

    Raises:
        Overdue: the command took longer.
    """
    with subprocess.Popen(command, text=True, start_new_session=True, **options) as process:
        try:
            said, errors = process.communicate(timeout=limit)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            raise Overdue(command, limit, process.communicate()[0]) from None
        except BaseException:  # Ctrl-C reaches no other session
            os.killpg(process.pid, signal.SIGKILL)
            raise
    return subprocess.CompletedProcess(command, process.returncode, said, errors)
