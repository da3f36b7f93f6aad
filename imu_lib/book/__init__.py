"""The book: where its chapters are, how they are executed, how it is built, and how it is rerun on
a user's record.

`chapters` knows the folders and the table of contents, `execute` runs notebooks so that two runs
give the same
bytes, `build` makes the pages, `rerun` does all of it on somebody's own record (`imu-lib book
FILE`).
"""
