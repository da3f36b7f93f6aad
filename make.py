#!/usr/bin/env python3
"""One door to everything: `python3 make.py TASK`, on Linux, macOS and Windows, Python 3.11 or
later.

Standard library only. Each task first makes sure that `.venv` holds what environment.txt lists and
the project itself (editable, with its command `imu-lib`); that takes a minute or two once and
nothing afterwards.

  book                    execute the chapters on the embedded data, then build book/_build/html
  test [PYTEST ARGS]      all tests and the notebooks' stored outputs; with arguments, just these
  refresh [NOTEBOOKS]     re-execute chapters (default: all) and store their outputs
  bench [NAMES]           run benchmarks/NAME.py (default: all) and store their tables
  pdf                     the whole book as one PDF (needs Chromium or Chrome)
  lint                    ruff over the code, rules and format; mypy over the rooms that are typed
"""

import contextlib
import hashlib
import os
import pathlib
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent
VENV = ROOT / ".venv"
WINDOWS = os.name == "nt"
PYTHON = VENV / ("Scripts/python.exe" if WINDOWS else "bin/python")
STAMP = VENV / "ready.txt"


class Stop(Exception):
    """Something to be said in one plain sentence; exit 2."""


def main(arguments):
    if sys.version_info < (3, 11):
        raise Stop(
            "make.py needs Python 3.11 or later, this is {}.{}: start it with a newer one, for "
            "instance `python3.12 make.py book`.".format(*sys.version_info[:2])
        )
    task = arguments[0] if arguments else ""
    if task in ("-h", "--help", "help"):
        print(__doc__)
        return 0
    if task not in TASKS:
        raise Stop(
            ("there is no task `{}`: ".format(task) if task else "a task is needed: ")
            + "choose one of "
            + ", ".join(TASKS)
            + "."
        )
    set_up()
    return TASKS[task](arguments[1:])


# ---- tasks --------------------------------------------------------------------------------------


def book(arguments):
    return run(PYTHON, "-m", "imu_lib.book", "build", *arguments)


def test(arguments):
    if arguments:
        return run(PYTHON, "-m", "pytest", *arguments)
    listing = subprocess.run(
        [str(PYTHON), "-m", "imu_lib.book", "executable"],
        cwd=ROOT,
        env=environment(),
        stdout=subprocess.PIPE,
        text=True,
    )
    if listing.returncode != 0:  # the package does not even import: its message stands above
        return listing.returncode
    notebooks = listing.stdout.split("\n")
    return run(
        PYTHON,
        "-m",
        "pytest",
        # long files first and in this order, short ones fill the end; the last chapter first, so
        # that the kernels of drives are compiled by one worker before the others ask for them;
        # three for two processors, as a worker often waits for a browser, a kernel or a process
        *filter(None, reversed(notebooks)),
        "tests",
        "-n",
        "3",
        "--dist",
        "loadfile",
        "--no-loadscope-reorder",
        "--nbval",
        "--nbval-current-env",
        "--nbval-cell-timeout",
        "300",
        "-q",
    )


def refresh(arguments):
    return run(PYTHON, "-m", "imu_lib.book", "refresh", *arguments)


def bench(arguments):
    scripts = {
        path.stem: path
        for path in sorted((ROOT / "benchmarks").glob("*.py"))
        if path.stem[0] != "_"
    }
    unknown = [name for name in arguments if name not in scripts]
    if unknown:
        raise Stop(
            "there is no benchmark `{}`: choose from {}.".format(unknown[0], ", ".join(scripts))
        )
    return max((run(PYTHON, scripts[name]) for name in arguments or scripts), default=0)


def pdf(arguments):
    return run(PYTHON, "-m", "imu_lib.book", "pdf", *arguments)


def lint(arguments):
    files = arguments or ["."]
    return (
        run(PYTHON, "-m", "ruff", "check", *files)
        or run(PYTHON, "-m", "ruff", "format", "--check", *files)
        or (0 if arguments else run(PYTHON, "-m", "mypy"))  # the rooms that pyproject.toml names
    )


TASKS = {"book": book, "test": test, "refresh": refresh, "bench": bench, "pdf": pdf, "lint": lint}


# ---- set-up -------------------------------------------------------------------------------------


def set_up():
    """Make `.venv` what environment.txt says; at once when it already is.

    The stamp is written last: without one the environment is made afresh, so an interrupted set-up
    does no harm.
    With the stamp of an earlier environment.txt, what changed is installed on top.
    """
    if is_ready():
        return
    with lock():
        if is_ready():  # another call has done it meanwhile
            return
        say("setting up .venv from environment.txt (once; one to four minutes)")
        if STAMP.exists() and works():
            done = install(uv=has_uv())
        else:
            done = (has_uv() and create(uv=True) and install(uv=True)) or (
                create(uv=False) and install(uv=False)
            )
        if not done:
            raise Stop(
                "the packages of environment.txt could not be installed (the messages above say "
                "why): check the network connection and run the same command again; deleting .venv "
                "starts afresh."
            )
        STAMP.write_text(fingerprint(), encoding="utf-8")
        say("set-up done")


def is_ready():
    return PYTHON.exists() and STAMP.exists() and STAMP.read_text(encoding="utf-8") == fingerprint()


def fingerprint():
    digest = hashlib.sha256()
    for part in (
        (ROOT / "environment.txt").read_bytes(),
        (ROOT / "pyproject.toml").read_bytes(),
        str(ROOT).encode(),
        sys.version.encode(),
    ):
        digest.update(hashlib.sha256(part).digest())
    return digest.hexdigest()


def has_uv():
    return shutil.which("uv") is not None


def works():
    """Does the environment's Python start, and is it the version that was asked for?"""
    probe = "import sys; sys.exit(sys.version_info[:2] != {!r})".format(sys.version_info[:2])
    return PYTHON.exists() and run(PYTHON, "-c", probe) == 0


def create(uv):
    if VENV.exists():
        shutil.rmtree(VENV)
    if uv:
        return run("uv", "venv", "--quiet", "--no-project", "--python", sys.executable, VENV) == 0
    if run(sys.executable, "-m", "venv", VENV) != 0:
        raise Stop(
            "Python could not make a virtual environment: on Debian and Ubuntu "
            "`sudo apt install python3-venv` adds what it lacks."
        )
    return True


def install(uv):
    if uv:
        pip = ["uv", "pip", "install", "--quiet", "--python", PYTHON]
    else:
        pip = [
            PYTHON,
            "-m",
            "pip",
            "install",
            "--quiet",
            "--disable-pip-version-check",
            "--no-input",
        ]
    # --no-build-isolation: the build back end is in environment.txt, nothing is fetched a second
    # time
    return (
        run(*pip, "-r", ROOT / "environment.txt") == 0
        and run(*pip, "--no-deps", "--no-build-isolation", "-e", ROOT) == 0
    )


@contextlib.contextmanager
def lock():
    """Two calls at once: the second waits. The system frees the lock when a process ends, however
    it ends.
    """
    with open(ROOT / ".make.lock", "w", encoding="utf-8") as handle:
        if WINDOWS:
            import msvcrt

            while True:
                try:
                    msvcrt.locking(handle.fileno(), msvcrt.LK_LOCK, 1)
                    break
                except OSError:  # LK_LOCK gives up after ten seconds
                    continue
        else:
            import fcntl

            fcntl.flock(handle, fcntl.LOCK_EX)
        yield


# ---- helpers ------------------------------------------------------------------------------------


def environment():
    """What every child process runs with: one thread per process, the kernel of this environment,
    UTF-8.
    """
    values = dict(
        os.environ,
        OMP_NUM_THREADS="1",
        OPENBLAS_NUM_THREADS="1",
        MKL_NUM_THREADS="1",
        PYTHONUTF8="1",
        JUPYTER_PREFER_ENV_PATH="1",
        PYDEVD_DISABLE_FILE_VALIDATION="1",
        VIRTUAL_ENV=str(VENV),
    )
    values["PATH"] = str(PYTHON.parent) + os.pathsep + values.get("PATH", "")
    if values.get(
        "IMU_LIB_DATA"
    ):  # chapters run in their own folder: what was meant from here must not change there
        values["IMU_LIB_DATA"] = os.path.abspath(values["IMU_LIB_DATA"])
    for name in (
        "MPLBACKEND",
        "PYTHONHOME",
        "PYTHONPATH",
        "PYTHONDONTWRITEBYTECODE",
    ):  # an outer setting would change figures or imports, or compile the package in each process
        values.pop(name, None)
    return values


def run(*command):
    return subprocess.run([str(part) for part in command], cwd=ROOT, env=environment()).returncode


def say(text):
    print("make.py: " + text, file=sys.stderr, flush=True)


if __name__ == "__main__":
    try:
        sys.exit(main(sys.argv[1:]))
    except Stop as stop:
        say(str(stop))
        sys.exit(2)
    except KeyboardInterrupt:
        say("interrupted")
        sys.exit(130)
