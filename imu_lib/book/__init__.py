"""The book: where its chapters are, how they are executed and built, and the pages about a user's
own record.

`chapters` knows the folders and the table of contents, `contents` what is derived from
chapters.toml, `execute` runs notebooks so that two runs give the same bytes, `build` makes the
pages, `pages` is the Sphinx extension behind them, `own` makes the book about somebody's own record
(`imu-lib book FILE`).
"""
