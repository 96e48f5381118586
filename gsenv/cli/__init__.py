"""The `gsenv` command: list, record, replay, view, play, train, evaluate, dataset, warmup, pack.

Exit codes: 0 success, 1 failure, 2 wrong command line, 130 interrupted (frames recorded so far are kept), 143 ended by
SIGTERM (files are as they were).
Results go to stdout; progress, and errors in one sentence, go to stderr.
"""

import sys
from collections.abc import Sequence

from .errors import FAILED, INTERRUPTED, CliError

_ADDED_BY_GYMNASIUM = " was raised from the environment creator"  # to a TypeError in `gymnasium.make`


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line (by default the process's own) and return the exit code."""
    try:
        from .parser import make_parser  # here, where Ctrl-C is caught: it loads numpy and more

        options = make_parser().parse_args(arguments)
        return int(options.run(options))
    except CliError as error:
        sentence = str(error).partition(_ADDED_BY_GYMNASIUM)[0]
        print(f"gsenv: {sentence}", file=sys.stderr)
        return error.exit_code
    except BrokenPipeError:  # e.g. `gsenv list | head -1`
        sys.stderr.close()  # or the interpreter reports the broken pipe at exit
        return FAILED
    except KeyboardInterrupt:
        print("gsenv: interrupted", file=sys.stderr)
        return INTERRUPTED
