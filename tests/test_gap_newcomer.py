"""An effect of one's own is one file: found, named, put into the model file, simulated, known again."""

import os
import subprocess
import sys

from conftest import ROOT

EFFECT = '''
"""A bias that alternates with the duty cycle of a second sensor beside this one."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from imu_lib.processes import Parameter
from imu_lib.processes.base import FREE
from imu_lib.processes.deterministic import Deterministic

from .drift import Drift


@dataclass(frozen=True)
class DutyCycle(Deterministic):
    amplitude: float = FREE
    period: float = FREE
    duty: float = FREE
    start: float = 0.0
    name: ClassVar[str] = "duty_cycle"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("amplitude", "signed", "while the other is on, signal unit"),
        Parameter("period", "time", "s"),
        Parameter("duty", "fraction", "of a period that it is on"),
        Parameter("start", "other", "of a period, s"),
    )

    def mean(self, t, temperature=None):
        into = np.mod(np.asarray(t, float) - self.start, self.period)
        return self.amplitude * (into < self.duty * self.period)


class AlternatingBias(Drift):
    name = "duty_cycle"
    cause = "A second sensor switches its heater or its radio on and off beside this one."
    shape = "period"

    def bounds(self, data):
        return np.log(data.duration / 24), np.log(data.duration / 4)

    def shapes(self, data):
        return [
            DutyCycle(amplitude=1.0, period=p, duty=d, start=float(s * p))
            for p in (data.duration / np.arange(4, 24, 0.4)).tolist()
            for d in (0.25, 0.5)
            for s in np.arange(8) / 8
        ]

    def around(self, process, data, reach, points):
        step = 0.4 * process.period**2 / data.duration
        far = np.linspace(-reach, reach, 7 if points < 100 else points)
        near = np.linspace(-reach, reach, 7) if points < 100 else [0.0]
        return [
            process.with_(
                period=float(process.period + a * step),
                # the middle of the record hangs least on the period
                start=float(process.start - a * step * data.duration / 2 / process.period
                            + b * process.period / 16),
                duty=float(np.clip(process.duty + c / 8, 0.05, 0.95)),
            )
            for a in far for b in near for c in near
        ]

    def penalty(self, data, snr):
        return -float(3 * np.log(max(snr, 1.0)) + np.log(100.0))

    def where(self, state, candidate):
        return f"mean of the signal: on and off every {candidate.process.period:.4g} s"


EFFECTS = (AlternatingBias(),)
'''
RUN = """
import numpy as np
from imu_lib.model import Model
entries = [{"process": "white_noise", "N": 1e-3}]
duty = {"process": "duty_cycle", "amplitude": 2e-3, "period": 75.0, "duty": 0.3, "start": 20.0}
grown = Model.from_json({"gyro_x": [*entries, duty]})  # before the workflow is imported
from imu_lib.gap.channel import analyse
x = grown["gyro_x"].simulate(36000, 40.0, np.random.default_rng(5))
found = analyse("gyro_x", x, 40.0, Model.from_json({"gyro_x": entries})["gyro_x"])
(step,) = found.steps
p = step.parameters
assert step.effect == "duty_cycle" and step.confidence > 0.9, step
assert abs(p["period"] - 75.0) < 0.5 and abs(p["duty"] - 0.3) < 0.05, p
assert step.intervals["amplitude"][0] < 2e-3 < step.intervals["amplitude"][1], step.intervals
again = Model.from_json({"gyro_x": found.model.to_json()})["gyro_x"]
assert again == found.model
other = again.simulate(36000, 40.0, np.random.default_rng(6))
nothing = analyse("gyro_x", other, 40.0, again)
assert not nothing.steps and nothing.unexplained is None, nothing
rng, f = np.random.default_rng(1), np.fft.rfftfreq(12_000, 0.01)
blue = np.fft.irfft(np.sqrt(f) * np.fft.rfft(rng.standard_normal(12_000)), 12_000)
x = 1e-3 * rng.standard_normal(12_000) + 2e-4 * blue  # 2 (2e-5)^2 f unit^2/Hz
found = analyse("gyro_x", x, 100.0, Model.from_json({"gyro_x": [{"process": "white_noise", "N": 1e-4}]})["gyro_x"])
(step,) = found.steps
assert step.effect == "blue_noise" and found.unexplained is None, found
assert step.intervals["A"][0] < 2e-5 < step.intervals["A"][1], step
"""


def test_one_file_is_an_effect(tmp_path):
    (tmp_path / "duty_cycle.py").write_text(EFFECT, encoding="utf-8")
    page = (ROOT / "book/contributing.md").read_text(encoding="utf-8")
    example = page.split("The whole of an effect", 1)[1].split("```python\n", 1)[1].split("```")[0]
    (tmp_path / "blue_noise.py").write_text(example, encoding="utf-8")
    env = {**os.environ, "IMU_LIB_EFFECTS": str(tmp_path), "PYTHONPATH": str(ROOT)}
    done = subprocess.run([sys.executable, "-c", RUN], env=env, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-3000:]
