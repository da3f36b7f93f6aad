"""The blind sensor: a record with hidden effects for each student of a class, and its marking."""

from imu_lib.exercise.hidden import Case, draw
from imu_lib.exercise.marking import Mark, mark
from imu_lib.exercise.papers import key_of, mark_all, write_class

__all__ = ["Case", "Mark", "draw", "key_of", "mark", "mark_all", "write_class"]
