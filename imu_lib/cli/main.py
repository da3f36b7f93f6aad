"""`imu-lib COMMAND ...`: the parser, the dispatch, and what a user sees when something is wrong.

A command is a module of this package with NAME, HELP, `add_arguments(parser)` and `run(args)`; it
is imported when it is asked for. Exit 0: done. Exit 2: the input or the call is at fault; one
sentence on standard error says what and the remedy.
"""

from __future__ import annotations

import argparse
import os
import re
import signal
import sys
from importlib import import_module, metadata
from importlib.util import find_spec

#: Command -> (module, aliases, one line for the list of commands). Listed in the order of a user's
#: work.
COMMANDS = {
    "check": ("check", (), "health of a record or drive: rate, gaps, units, is it at rest"),
    "characterise": (
        "characterise",
        ("characterize",),
        "all methods on all channels; coefficients with intervals, model file, exports",
    ),
    "simulate": ("simulate", (), "a record drawn from an error model"),
    "gap": ("gap", (), "where simulation and measurement disagree, and what is missing"),
    "calibrate": (
        "calibrate",
        (),
        "bias, scale factor, cross-coupling from static poses or a rate table",
    ),
    "outages": ("outages", (), "error models compared under GPS outages of a drive"),
    "compare": ("compare", (), "two models or two records of one sensor side by side"),
    "fleet": ("fleet", (), "many records, one table: spread over units, outliers, drift"),
    "book": ("book", (), "the book re-executed on your own record"),
    "exercise": ("exercise", (), "records with hidden effects for a class, and their marking"),
    "data": ("data", (), "the public records of the registry"),
}


class Parser(argparse.ArgumentParser):
    """argparse with one sentence instead of a usage page, and no guessing of abbreviated
    options.
    """

    def __init__(self, *args, **kwargs):
        super().__init__(*args, allow_abbrev=False, **kwargs)

    def error(self, message):
        option = re.fullmatch(r"argument (\S+): expected one argument", message)
        if option:
            message = (
                f"{option[1]} needs a value; one that begins with a minus is written with `=`, as "
                f"in `{option[1]}=-5`"
            )
        self.exit(
            2,
            f"{self.prog}: {message[:1].upper()}{message[1:]}; `{self.prog} --help` shows the "
            "call.\n",
        )


def there() -> dict[str, tuple]:
    """The commands whose module is installed."""
    return {name: entry for name, entry in COMMANDS.items() if find_spec(f"imu_lib.cli.{entry[0]}")}


def parser(command: str | None = None) -> Parser:
    """The parser; only the module of `command` is imported (None: none)."""
    out = Parser(
        prog="imu-lib",
        description="Errors of low-cost inertial sensors: measure, model, simulate, compare.",
        epilog="`imu-lib COMMAND --help` shows the options of a command. A model is a file or a "
        "preset (preset:3dm-gx3-25).",
    )
    out.add_argument("--version", action="version", version=f"imu-lib {_version()}")
    commands = out.add_subparsers(
        dest="command", metavar="COMMAND", required=True, parser_class=Parser
    )
    for name, (module, aliases, about) in there().items():
        if command in (name, *aliases):
            found = import_module(f"imu_lib.cli.{module}")
            sub = commands.add_parser(
                name, aliases=aliases, help=about, description=getattr(found, "HELP", about)
            )
            found.add_arguments(sub)
            sub.set_defaults(run=found.run, writes=getattr(found, "WRITES", ()))
        else:
            commands.add_parser(name, aliases=aliases, help=about, add_help=False)
    return out


def _version() -> str:
    try:
        return metadata.version("imu_lib")
    except metadata.PackageNotFoundError:
        return "(source tree)"


#: Options whose value may begin with a minus: a skipped column, a negative time.
SIGNED = ("--columns", "--start", "--stop", "--gnss-offset")


def joined(argv: list[str]) -> list[str]:
    """`--columns -,time` as `--columns=-,time`: argparse takes a word that begins with a minus for
    an option.
    """
    out: list[str] = []
    for word in argv:
        if out and out[-1] in SIGNED and word.startswith("-") and not word.startswith("--"):
            out[-1] = f"{out[-1]}={word}"
        else:
            out.append(word)
    return out


def main(argv: list[str] | None = None) -> int:
    """Run one command; returns the exit status."""
    if argv is None:
        argv = sys.argv[1:]
        signal.signal(
            signal.SIGTERM, lambda *_: sys.exit(143)
        )  # temporary files are cleaned up on the way out
    argv = joined(argv)
    # matrices here are small: threads of the linear algebra would only wait for each other
    for library in ("OPENBLAS", "MKL", "OMP"):
        os.environ.setdefault(f"{library}_NUM_THREADS", "1")
    command = next((a for a in argv if not a.startswith("-")), None)
    from imu_lib.errors import ImuLibError

    try:
        args = parser(command).parse_args(argv)
        from imu_lib.cli import named, outputs
        from imu_lib.cli.common import json_alone

        if outputs.descriptor(getattr(args, "json", None)) == 1:
            args.json = "-"  # standard output by another name
        named.check(args)
        with json_alone(getattr(args, "json", None)):
            return int(args.run(args) or 0)
    except ImuLibError as error:
        return _fault(str(error))
    except OSError as error:
        if isinstance(error, BrokenPipeError):  # `imu-lib ... | head`
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            return 0
        return _fault(_of_os(error))
    except MemoryError:
        return _fault(
            "There is not enough memory for this record; take a part of it with --start and --stop."
        )
    except KeyboardInterrupt:
        print("imu-lib: Stopped; nothing half-written was left behind.", file=sys.stderr)
        return 130
    except SystemExit as stop:
        return stop.code if isinstance(stop.code, int) else 2 if stop.code else 0


def _of_os(error: OSError) -> str:
    """An operating-system error as a sentence with its remedy."""
    name = error.filename if isinstance(error.filename, str) else str(error.filename or "")
    remedy = {
        FileNotFoundError: "does not exist; check the path",
        PermissionError: "may not be read or written; check its permissions",
        IsADirectoryError: "is a directory; name a file",
        NotADirectoryError: "has a file where a folder should be; check the path",
        FileExistsError: "is there already and not what is needed; choose another name",
    }.get(type(error))
    if remedy:
        return f"{name or 'A file'} {remedy}."
    return f"{name + ': ' if name else ''}{error.strerror or error}."


def _fault(sentence: str) -> int:
    print(f"imu-lib: {' '.join(sentence.split())}", file=sys.stderr)
    return 2


if __name__ == "__main__":
    sys.exit(main())
