"""Exit codes, and errors that are reported in one sentence."""

OK, FAILED, WRONG_USAGE, INTERRUPTED = 0, 1, 2, 130


class CliError(Exception):
    """An error that is reported in one sentence, with the command's exit code."""

    def __init__(self, message: str, exit_code: int) -> None:
        super().__init__(message)
        self.exit_code = exit_code
