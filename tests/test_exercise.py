"""The blind sensor: the same seed gives the same class, right answers get full marks, wrong names
none.
"""

import json
import time

import numpy as np
import pytest

from imu_lib import read_drive, read_record
from imu_lib.cli.main import main
from imu_lib.exercise import draw, drives, mark, mark_all, write_class
from imu_lib.exercise.hidden import EFFECTS
from imu_lib.model import Model

LENGTH = 1800.0
HIDDEN = [
    ("gyro_x", "step", {"amplitude": 1e-4, "time": 700.0}),
    ("accel_z", "sinusoid", {"amplitude": 2e-3, "frequency": 7.0}),
]


def answered(*given):
    channels = {}
    for channel, effect, parameters in given:
        channels.setdefault(channel, []).append({"effect": effect, "parameters": parameters})
    return {"channels": channels}


def test_right_answers_get_full_marks():
    found = mark(HIDDEN, answered(*HIDDEN), length=LENGTH)
    assert (found.points, found.named, found.wrong) == (pytest.approx(100.0), 2, 0)


def test_a_wrong_name_or_channel_gets_none():
    assert mark(HIDDEN, answered(("gyro_x", "ramp", {"R": 1.0})), length=LENGTH).points == 0.0
    elsewhere = [(c.replace("x", "y"), e, p) for c, e, p in HIDDEN[:1]]
    assert mark(HIDDEN, answered(*elsewhere), length=LENGTH).points == 0.0
    assert mark(HIDDEN, {"channels": {}}, length=LENGTH).points == 0.0


def test_names_count_more_than_parameters_and_guesses_cost():
    bare = [(c, e, {}) for c, e, _ in HIDDEN]
    assert mark(HIDDEN, answered(*bare), length=LENGTH).points == pytest.approx(60.0)
    guess = ("gyro_y", "ramp", {})
    assert mark(HIDDEN, answered(*HIDDEN, guess), length=LENGTH).points == pytest.approx(90.0)
    # naming everything everywhere does not pay
    everything = [(f"{k}_{a}", e, {}) for k in ("gyro", "accel") for a in "xyz" for e in EFFECTS]
    assert mark(HIDDEN, answered(*everything), length=LENGTH).points == 0.0


def test_a_parameter_off_by_more_earns_less():
    points = [
        mark(
            HIDDEN[:1],
            answered(("gyro_x", "step", {"amplitude": a, "time": 700.0})),
            length=LENGTH,
        ).points
        for a in (1e-4, 1.1e-4, 1.25e-4, 2e-4)
    ]
    assert points[:2] == pytest.approx([100.0, 100.0]) and 100.0 > points[2] > points[3]
    assert points[3] == pytest.approx(80.0)  # the time is right


def test_a_class_is_drawn_from_its_seed(tmp_path):
    key = write_class(tmp_path / "a", 2, 7, minutes=5.0)
    again = write_class(tmp_path / "b", 2, 7, minutes=5.0)
    assert key.read_text() == again.read_text()
    first, second = (read_record(tmp_path / f"a/student_0{i}/record.npz") for i in (1, 2))
    same = read_record(tmp_path / "b/student_01/record.npz")
    assert np.array_equal(first["gyro_x"], same["gyro_x"])
    assert not np.array_equal(first["gyro_x"], second["gyro_x"])
    assert Model.load(tmp_path / "a/student_01/model.json").channel_names == first.channel_names
    sheet = (tmp_path / "a/student_01/sheet.md").read_text()
    assert all(f"`{effect}`" in sheet for effect in EFFECTS)
    content = json.loads(key.read_text())["students"]
    assert all(2 <= len(effects) <= 3 for effects in content.values())


def test_what_is_hidden_shows():
    """Each effect changes its channel by more than chance: the strengths are drawn for that."""
    seen = set()
    for seed in range(12):
        case = draw(np.random.default_rng(seed), minutes=10.0)
        base = case.base.simulate(30_000, 50.0, np.random.default_rng([seed, 1]))
        for channel, effect, _ in case.hidden:
            x, y = case.record[channel], base[channel]
            slow = [np.std(v.reshape(30, -1).mean(axis=1)) for v in (x, y)]
            lines = [np.max(np.abs(np.fft.rfft(v - v.mean()))[300:]) for v in (x, y)]
            values = len(np.unique(x)) / x.size
            differs = (
                slow[0] > 1.5 * slow[1]
                or lines[0] > 1.5 * lines[1]
                or abs(np.std(x) / np.std(y) - 1) > 0.02
                or values < 0.95
                or np.max(np.abs(x - x.mean())) > 1.3 * np.max(np.abs(y - y.mean()))
            )
            assert differs, (seed, channel, effect)
            seen.add(effect)
    assert len(seen) >= 8


def test_two_hundred_students_are_marked_in_a_minute(tmp_path):
    started = time.monotonic()
    key = {"seed": 1, "minutes": 30.0, "rate": 50.0, "students": {}}
    for number in range(200):
        name = f"{number:03d}"
        hidden = draw(np.random.default_rng([1, number]), minutes=0.5).hidden
        key["students"][name] = [{"channel": c, "effect": e, "parameters": p} for c, e, p in hidden]
        (tmp_path / f"student_{name}").mkdir()
        right = number % 2 == 0
        given = answered(*[(c, e if right else "low_pass", p) for c, e, p in hidden])
        path = tmp_path / f"student_{name}/answers.json"
        path.write_text(json.dumps({"student": name, **given}))
    (tmp_path / "key.json").write_text(json.dumps(key))
    marks = mark_all(tmp_path, tmp_path / "key.json")
    assert [round(m.points) for m in marks.values()] == [100, 0] * 100
    assert time.monotonic() - started < 60.0


def test_on_the_command_line(tmp_path, capsys):
    out = tmp_path / "class"
    call = ["exercise", "new", "--class", "2", "--seed", "3", "--minutes", "5", "--out", str(out)]
    assert main(call) == 0
    assert "2 students in" in capsys.readouterr().out
    call[3], call[-1] = "1", str(tmp_path / "alone")
    assert main(call) == 0 and "1 student in" in capsys.readouterr().out
    assert main(["exercise", "mark", str(out), "--out", str(tmp_path / "marks")]) == 0
    assert "mean 0.0 of 100" in capsys.readouterr().out
    assert (tmp_path / "marks/marks.csv").read_text().splitlines()[1].startswith("01,0.0")
    assert (tmp_path / "marks/feedback_01.md").exists()


def answer(effect, parameters):
    step = f'{{"effect": "{effect}", "parameters": {parameters}}}'
    return f'{{"student": "01", "channels": {{"gyro_x": [{step}]}}}}'


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ("{", "is not valid JSON"),
        ('{"student": "99", "channels": {}}', "no student '99'"),
        ('{"student": "01"}', 'there is no "channels"'),
        ('{"student": "01", "channels": {"gyro_x": 3}}', "are no list of effects"),
        ('{"student": "01", "channels": {"gyro_x": [{"name": "step"}]}}', 'has no "effect"'),
        ("", "is empty"),
        ("3", "are no answers"),
        ('{"student": "01", "channels": {"gyros_x": []}}', "is gyro_x meant?"),
        ('{"student": "01", "channels": [{"effect": "step"}]}', 'has no "channel"'),
        (answer("step", '{"time": "5:10"}'), 'time is "5:10"; a number in SI units'),
        (answer("sinus", "{}"), "is sinusoid meant?"),
        (answer("step", '{"time": "12 min"}'), 'time is "12 min"; a number in SI units'),
        (answer("step", '{"time": "1,180"}'), 'time is "1,180"; a number in SI units'),
        (answer("clipping", "{}"), "is saturation meant?"),
        (answer("Popcorn noise", "{}"), "is telegraph meant?"),
        (answer("step", '{"time": NaN}'), "time is nan, which is no number"),
        ('{"student": "01", "channels": {"gyro_x": [], "gyro_x": []}}', '"gyro_x" stands twice'),
    ],
)
def test_bad_answers_are_told_in_a_sentence(tmp_path, capsys, content, said):
    write_class(tmp_path / "class", 1, 3, minutes=5.0)
    path = tmp_path / "class/student_01/answers.json"
    path.write_text(content)
    assert main(["exercise", "mark", str(path)]) == 2
    told = capsys.readouterr().err
    assert said in told and len(told.strip().splitlines()) == 1


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16"])
def test_what_is_meant_is_marked(tmp_path, encoding):
    """However an editor saves it: other letters, a number in quotes, 1 for 01, one without a list."""
    hidden = [{"channel": c, "effect": e, "parameters": p} for c, e, p in HIDDEN]
    key = {"minutes": 30.0, "students": {"01": hidden}}
    (tmp_path / "key.json").write_text(json.dumps(key))
    given = {
        "student": 1,
        "channels": {
            "Gyro X": {"effect": "Step", "parameters": {"Amplitude": "0,0001", "time": "700 s"}},
            "accel_z": [{"effect": "sinusoid", "parameters": HIDDEN[1][2]}],
        },
    }
    (tmp_path / "answers.json").write_bytes(json.dumps(given).encode(encoding))
    marks = mark_all(tmp_path, tmp_path / "key.json")
    assert marks["01"].points == pytest.approx(100.0)


STEP, TONE = (p for _, _, p in HIDDEN)


@pytest.mark.parametrize(
    "channels",
    [
        [{"channel": c, "effect": e, "parameters": p} for c, e, p in HIDDEN],
        {"gyro_x": {"effect": "step", **STEP}, "accel_z": [{"effect": "sinusoid", **TONE}]},
        {"GyroX": [{"effect": "Step", **STEP}], "accel.z": [{"effect": "SINUSOID", **TONE}]},
        {
            "gyro-x": [{"effect": "step", "parameters": {"amplitude": "1e-4 rad/s", "TIME": 700}}],
            "Accel Z": {"steps": [{"effect": "sinusoid", "parameters": TONE}]},
        },
        {
            "gyro_x": [{"effect": "step", "parameters": STEP}],
            "accel_z": [{"effect": "sinusoid", "amplitude": -2e-3, "Frequency": "7 Hz"}],
        },
    ],
)
def test_odd_forms_of_the_right_answer_get_full_marks(channels):
    """A flat list, parameters beside the effect, capitals and hyphens, the other phase of a wave."""
    assert mark(HIDDEN, {"channels": channels}, length=LENGTH).points == pytest.approx(100.0)


def test_of_an_effect_named_twice_the_nearer_counts():
    far = ("gyro_x", "step", {"amplitude": 9.0, "time": 3.0})
    for given in ((far, *HIDDEN), (*HIDDEN, far)):
        found = mark(HIDDEN, answered(*given), length=LENGTH)
        assert (found.named, found.wrong) == (2, 1) and found.points == pytest.approx(90.0)


def test_an_empty_sheet_beside_the_answers_is_passed_over(tmp_path):
    hidden = [{"channel": c, "effect": e, "parameters": p} for c, e, p in HIDDEN]
    key = {"minutes": 30.0, "students": {"01": hidden, "02": hidden}}
    (tmp_path / "key.json").write_text(json.dumps(key))
    for number in ("01", "02"):
        (tmp_path / f"student_{number}").mkdir()
        sheet = json.dumps({"student": number, "channels": {}})
        (tmp_path / f"student_{number}/answers.json").write_text(sheet)
    given = json.dumps({"student": "Student 1", **answered(*HIDDEN)})
    (tmp_path / "student_01/Answers final.json").write_text(given)
    marks = mark_all(tmp_path, tmp_path / "key.json")
    assert {name: round(m.points) for name, m in marks.items()} == {"01": 100, "02": 0}


def test_one_faulty_file_does_not_stop_a_class(tmp_path, capsys):
    write_class(tmp_path / "class", 3, 3, minutes=5.0)
    (tmp_path / "class/student_02/answers.json").write_text("{")
    assert main(["exercise", "mark", str(tmp_path / "class"), "--out", str(tmp_path / "m")]) == 0
    told = capsys.readouterr()
    assert told.err.startswith("not marked: ") and len(told.err.strip().splitlines()) == 1
    table = (tmp_path / "m/marks.csv").read_text()
    assert table.count("\n") == 4 and "02,,,,,not marked:" in table
    named_twice = mark(HIDDEN, answered(*HIDDEN, HIDDEN[0]), length=LENGTH)
    assert "more often" in named_twice.feedback[-1] and named_twice.points < 100


def test_a_class_of_faulty_files_is_told_in_one_go(tmp_path, capsys):
    write_class(tmp_path / "class", 2, 3, minutes=5.0)
    for number in (1, 2):
        (tmp_path / f"class/student_0{number}/answers.json").write_text("{")
    assert main(["exercise", "mark", str(tmp_path / "class")]) == 2
    assert capsys.readouterr().err.count("is not valid JSON") == 2


def test_a_sign_is_told():
    (channel, effect, true), *_ = HIDDEN
    other = {**true, "amplitude": -true["amplitude"]}
    found = mark([HIDDEN[0]], answered((channel, effect, other)), length=LENGTH)
    assert "wrong in its sign" in found.feedback[0] and 60 <= found.points < 100


def test_a_folder_that_is_there_is_not_written_over(tmp_path, capsys):
    (tmp_path / "mine.txt").write_text("kept")
    call = ["exercise", "new", "--class", "1", "--seed", "3", "--out", str(tmp_path)]
    assert main(call) == 2 and "is there already" in capsys.readouterr().err
    assert (tmp_path / "mine.txt").read_text() == "kept"


DRIVE = [
    ("drive", "lever_arm", {"arm": [1.0, 0.5, 0.0]}),
    ("drive", "vibration", {"channel": "accel_z", "N_per_speed": 0.004}),
]


def of_drive(*given):
    return {"drive": [{"effect": e, "parameters": p} for _, e, p in given]}


def test_a_drive_is_marked_by_names_and_vectors():
    assert mark(DRIVE, of_drive(*DRIVE), length=480.0).points == pytest.approx(100.0)
    workflow = {"drive": {"steps": of_drive(*DRIVE)["drive"]}}  # what gap --json writes
    assert mark(DRIVE, workflow, length=480.0).points == pytest.approx(100.0)
    near = [("drive", "lever_arm", {"arm": [1.0, 0.5, 0.4]}), DRIVE[1]]
    far = [("drive", "lever_arm", {"arm": [-1.0, 0.5, 0.0]}), DRIVE[1]]
    points = [mark(DRIVE, of_drive(*a), length=480.0).points for a in (near, far)]
    assert 100.0 > points[0] > points[1] == pytest.approx(80.0)  # a name without its parameter
    odd = [("drive", "lever_arm", {"arm": "far"}), DRIVE[1]]
    assert mark(DRIVE, of_drive(*odd), length=480.0).points == pytest.approx(80.0)


def test_a_class_of_drives_is_drawn_from_its_seed(tmp_path):
    key = write_class(tmp_path / "a", 2, 7, kind="drive", minutes=1.0)
    again = write_class(tmp_path / "b", 2, 7, kind="drive", minutes=1.0)
    assert key.read_text() == again.read_text()
    drive = read_drive(tmp_path / "a/student_01/drive.npz")
    same = read_drive(tmp_path / "b/student_01/drive.npz")
    assert np.array_equal(drive.gyro, same.gyro) and abs(drive.duration - 60.0) < 1.0
    assert not drive.has_reference and not np.any(drive.lever_arm)  # nothing gives it away
    sheet = (tmp_path / "a/student_01/sheet.md").read_text()
    assert all(f"`{effect}`" in sheet for effect in drives.EFFECTS)
    content = json.loads(key.read_text())
    right = of_drive(
        *[(h["channel"], h["effect"], h["parameters"]) for h in content["students"]["01"]]
    )
    (tmp_path / "a/student_01/answers.json").write_text(json.dumps({"student": "01", **right}))
    marks = mark_all(tmp_path / "a", key)
    assert marks["01"].points == pytest.approx(100.0) and marks["02"].points == 0.0
