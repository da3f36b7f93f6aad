"""`imu-lib exercise new` and `imu-lib exercise mark`: the blind sensor for a class."""

from __future__ import annotations

import argparse
import sys
from dataclasses import asdict
from pathlib import Path

from imu_lib import words
from imu_lib.cli import common, named
from imu_lib.errors import InputError

NAME = "exercise"
#: Names of the files in --out DIR.
WRITES = ("marks.csv", "feedback_*.md")
HELP = "The blind sensor: a record or drive with hidden effects for each student, and its marking."


def add_arguments(parser: argparse.ArgumentParser) -> None:
    tasks = parser.add_subparsers(dest="task", metavar="TASK", required=True)
    new = tasks.add_parser("new", help="write a folder with a record and a sheet for each student")
    new.add_argument("--class", dest="count", type=int, required=True, metavar="N", help="students")
    new.add_argument("--seed", type=int, required=True, help="the same seed gives the same class")
    new.add_argument(
        "--kind", choices=("record", "drive"), default="record", help="a sensor at rest, or a car"
    )
    new.add_argument(
        "--minutes", type=float, help="length of a record (default: 30) or a drive (default: 8)"
    )
    new.add_argument(
        "--rate", type=float, default=50.0, metavar="HZ", help="of a record (default: 50)"
    )
    new.add_argument("--out", metavar="DIR", help="a new folder (default: exercise_SEED)")
    marking = tasks.add_parser("mark", help="mark answers against the key")
    marking.add_argument("answers", help="a file answers.json, or a folder of them")
    marking.add_argument("--key", metavar="FILE", help="key.json (default: beside the answers)")
    marking.add_argument("--out", metavar="DIR", help="marks.csv and a feedback for each student")
    marking.add_argument("--json", metavar="FILE", help="all marks with their feedback")


def run(args: argparse.Namespace) -> int:
    return new(args) if args.task == "new" else marks(args)


def new(args) -> int:
    from imu_lib.exercise import write_class

    usual = 8.0 if args.kind == "drive" else 30.0
    args.minutes = usual if args.minutes is None else args.minutes
    for value, least, most, flag in (
        (args.count, 1, 1000, "--class"),
        (args.seed, 0, 2**32, "--seed"),
        (args.minutes, 5.0, 240.0, "--minutes"),
        (args.rate, 10.0, 400.0, "--rate"),
    ):
        if not least <= value <= most:
            raise InputError(f"{flag} is {value:g}; it has to lie from {least:g} to {most:.10g}.")
    out = args.out or f"exercise_{args.seed}"
    key = write_class(
        out, args.count, args.seed, kind=args.kind, minutes=args.minutes, rate=args.rate
    )
    print(f"{words.number(args.count, 'student')} in {out}; the key, for the teacher alone: {key}")
    return 0


def marks(args) -> int:
    from imu_lib.exercise import key_of, mark_all
    from imu_lib.exercise.papers import write_marks

    answers = Path(args.answers)
    if not answers.exists():
        raise InputError(f"{answers} does not exist; name a file of answers or their folder.")
    common.check_writable(args.json)
    common.check_out(args.out)
    key = args.key or key_of(answers)
    named.refuse_overwriting(args, [key])
    faulty: dict = {}
    found = mark_all(answers, key, faulty=faulty)
    print("student  points  hidden  named  wrong")
    for name, m in found.items():
        print(f"{name:>7}  {m.points:6.1f}  {m.hidden:6}  {m.named:5}  {m.wrong:5}")
    if len(found) == 1:
        print(*next(iter(found.values())).feedback, sep="\n")
    else:
        print(f"mean {sum(m.points for m in found.values()) / len(found):.1f} of 100")
    for sentence in faulty.values():
        print(f"not marked: {sentence}", file=sys.stderr)
    if args.out:
        write_marks(found, args.out, faulty)
    if args.json:
        common.write_json({name: asdict(m) for name, m in found.items()}, args.json)
    return 0
