"""`imu-lib data list` and `imu-lib data fetch NAME`: the public records of the registry."""

from __future__ import annotations

from imu_lib.cli import common

NAME = "data"
HELP = "The public records of the registry: list them, fetch one."


def add_arguments(parser):
    actions = parser.add_subparsers(dest="action", metavar="list | fetch NAME", required=True)
    common.add_json_argument(
        actions.add_parser("list", help="names, sensors, licences, and which are at hand")
    )
    fetch = actions.add_parser(
        "fetch", help="download a record (checked by its SHA-256) and convert it for the readers"
    )
    fetch.add_argument("name", metavar="NAME", help="a name of `imu-lib data list`")
    common.add_json_argument(fetch)


def run(args):
    from imu_lib import datasets

    common.check_writable(args.json)
    if args.action == "list":
        result = {
            name: {
                **{k: v for k, v in about.items() if k != "convert"},
                "available": datasets.available(name),
            }
            for name, about in datasets.registry().items()
        }
        common.write_json(result, args.json)
        if args.json != "-":
            rows = [
                (
                    n,
                    a["kind"],
                    "yes" if a["available"] else "no",
                    f"{sum(s['bytes'] for s in a['sources']) / 1e6:.1f}",
                    a["sensor"],
                )
                for n, a in result.items()
            ]
            width = max(len(r[0]) for r in rows)
            print(f"{'name'.ljust(width)}  {'kind'.ljust(11)}  here   MB    sensor; licence")
            for name, kind, here, size, sensor in rows:
                print(
                    f"{name.ljust(width)}  {kind.ljust(11)}  {here.ljust(4)}  {size.rjust(4)}  "
                    f"{sensor}; {result[name]['licence']}"
                )
        return
    at_hand = datasets.available(args.name)
    files = datasets.paths(args.name) if at_hand else datasets.fetch(args.name, progress=True)
    common.write_json({"name": args.name, "files": [str(f) for f in files]}, args.json)
    if args.json != "-":
        print("\n".join(str(f) for f in files))
