"""What all tests share: one thread per worker, figures without a screen, the folder of real
records, nbval with history.
"""

import os

for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_name, "1")  # before numpy is imported: the workers share the cores

from pathlib import Path  # noqa: E402

import matplotlib  # noqa: E402
import pytest  # noqa: E402
from nbval.kernel import RunningKernel  # noqa: E402

matplotlib.use("Agg")

ROOT = Path(__file__).resolve().parent


def _execute_cell_input(self, cell_input, allow_stdin=None):
    """nbval executes cells without history; IPython looks there for the semicolon that keeps axes
    from being printed.
    """
    return self.kc.execute(
        cell_input, store_history=True, allow_stdin=allow_stdin, stop_on_error=False
    )


RunningKernel.execute_cell_input = _execute_cell_input


@pytest.fixture(scope="session")
def root():
    """The project's folder."""
    return ROOT


@pytest.fixture(scope="session")
def data_dir():
    """The folder of real records, `IMU_LIB_DATA`; tests that need it are skipped where it is not
    there.
    """
    value = os.environ.get("IMU_LIB_DATA", "")
    if not value:
        pytest.skip("real records are not at hand: IMU_LIB_DATA is not set")
    path = Path(value) if Path(value).is_absolute() else ROOT / value
    if not path.is_dir():
        pytest.skip(f"real records are not at hand: IMU_LIB_DATA={value} is not a folder")
    return path


@pytest.fixture(autouse=True)
def close_figures():
    """No test leaves a figure open for the next one."""
    yield
    if "matplotlib.pyplot" in __import__("sys").modules:
        import matplotlib.pyplot as plt

        plt.close("all")
