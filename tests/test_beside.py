"""A file appears whole or not at all."""

import os
import stat

import pytest

from imu_lib import beside


def test_a_file_appears_whole_or_not_at_all(tmp_path):
    path = tmp_path / "a.json"
    path.write_text("old")
    with pytest.raises(KeyboardInterrupt), beside.whole(path) as part:
        part.write_text("half")
        raise KeyboardInterrupt
    assert [p.name for p in tmp_path.iterdir()] == ["a.json"] and path.read_text() == "old"
    link = tmp_path / "link"
    link.symlink_to(path)
    with beside.whole(link, sync=True) as part:
        assert part.suffix == ".json" and part.parent == tmp_path
        part.write_text("new")
    assert link.is_symlink() and path.read_text() == "new"
    umask = os.umask(0o027)
    try:
        with beside.whole(path) as part:
            part.write_text("newer")
    finally:
        os.umask(umask)
    assert stat.S_IMODE(path.stat().st_mode) == 0o640
    assert len(list(tmp_path.iterdir())) == 2
