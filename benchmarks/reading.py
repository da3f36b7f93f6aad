"""How long reading takes: six axes of seven hours at 100 Hz out of every format the commands
write.

`python benchmarks/reading.py` writes benchmarks/results/reading.json. Each file is read by a fresh
process, three times; the least time counts (the others measure the machine's other work), with
processor time beside it.
"""

import datetime
import json
import os
import platform
import subprocess
import sys
import tempfile
from pathlib import Path

RESULT = Path(__file__).parent / "results" / "reading.json"
CODE = """
import sys, time, resource
from imu_lib.readers import read_record
wall, cpu = time.perf_counter(), time.process_time()
record = read_record(sys.argv[1], trust_units=True)
print(time.perf_counter() - wall, time.process_time() - cpu, record.n)
"""


def main():
    import numpy
    import pandas
    import pyarrow

    from imu_lib import datasets
    from imu_lib.writers import write_record

    record = datasets.twin()
    rows = {}
    with tempfile.TemporaryDirectory() as folder:
        for suffix in ("npz", "parquet", "csv"):
            path = Path(folder) / f"record.{suffix}"
            write_record(record, path)
            runs = [
                subprocess.run(
                    [sys.executable, "-c", CODE, str(path)],
                    capture_output=True,
                    text=True,
                    check=True,
                ).stdout.split()
                for _ in range(3)
            ]
            wall, cpu, n = min((float(w), float(c), int(n)) for w, c, n in runs)
            rows[suffix] = {
                "megabytes": round(path.stat().st_size / 1e6, 1),
                "samples": n,
                "seconds": round(wall, 2),
                "processor_seconds": round(cpu, 2),
                "processor_seconds_per_million_rows": round(cpu / n * 1e6, 2),
            }
            print(f"{suffix:8s} {rows[suffix]}", flush=True)
    result = {
        "command": "python benchmarks/reading.py",
        "date": datetime.date.today().isoformat(),
        "load_average": os.getloadavg()[0] if hasattr(os, "getloadavg") else None,
        "versions": {
            "python": platform.python_version(),
            **{m.__name__: m.__version__ for m in (numpy, pandas, pyarrow)},
        },
        "record": "six axes, 7 h at 100 Hz, with a time column",
        "formats": rows,
    }
    RESULT.parent.mkdir(exist_ok=True)
    RESULT.write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
