"""Standard output and error of a program that runs anywhere: any encoding, closed, or on a device that is full."""

import io
import os
import signal
import sys
from contextlib import suppress
from types import FrameType

import click


class Terminated(KeyboardInterrupt):
    """The system or another program asked this one to end."""


def take_any_text() -> None:
    """Have letters that an output's encoding lacks, and names that are no text, written as escapes."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            with suppress(OSError, ValueError):  # closed, or full already
                stream.reconfigure(errors="backslashreplace")


def end_on_signals() -> None:
    """Have a request to terminate end the program as Ctrl-C does: nothing half-written is left."""

    def end(number: int, _: FrameType | None) -> None:
        raise Terminated(number)

    with suppress(ValueError):  # not the main thread: signals are another's
        for name in ("SIGTERM", "SIGHUP"):
            number = getattr(signal, name, None)
            if number is not None and signal.getsignal(number) is signal.SIG_DFL:
                signal.signal(number, end)


def say(line: str) -> None:
    """Write a line to standard error, where that can be written to."""
    with suppress(OSError, ValueError):
        click.echo(line, err=True)


def give_up_output() -> None:
    """Send what is left to be written on standard output nowhere: the interpreter would fail on it as it ends."""
    with suppress(OSError, ValueError):
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, sys.stdout.fileno())
        os.close(nowhere)
