"""Data sets in a tree of groups, read by slices: HDF5 files and Zarr stores."""

from __future__ import annotations

from contextlib import contextmanager
from dataclasses import dataclass

from imu_lib.readers import zarr_store
from imu_lib.stream import bounds


@dataclass(frozen=True)
class Tree:
    """Columns of a tree of data sets; a kind of file says how it is opened and walked."""

    path: str

    def _open(self):
        """A context whose value gives a data set under its name."""
        raise NotImplementedError

    def _shapes(self):
        """Name of each data set of numbers -> its shape."""
        raise NotImplementedError

    def _sets(self):
        """Column -> (data set, axis of three or None, whether the rows are its last dimension,
        number of rows).
        """
        out = {}
        for name, shape in self._shapes().items():
            key = name.replace("/", ".")
            if len(shape) == 1:
                out[key] = name, None, False, shape[0]
            elif len(shape) == 2 and 3 in shape and max(shape) > 3:
                last = shape[0] == 3
                for i, axis in enumerate("xyz"):
                    out[f"{key}_{axis}"] = name, i, last, max(shape)
            elif len(shape) == 2 and 1 in shape:
                out[key] = name, 0, shape[0] == 1, max(shape)
        return out

    def columns(self):
        """Name -> number of rows, of the columns that hold numbers."""
        return {key: n for key, (_, _, _, n) in self._sets().items()}

    def pieces(self, name, start, stop):
        """The values start ... stop - 1 of a column, ndarrays in order."""
        held, axis, last, _ = self._sets()[name]
        with self._open() as tree:
            for low, high in bounds(stop - start):
                rows = slice(start + low, start + high)
                at = rows if axis is None else (axis, rows) if last else (rows, axis)
                yield tree[held][at]

    def head(self, rows, path):
        """The first rows as a file of the same kind."""
        self.rows(0, rows, path)

    def _slices(self, tree, start, stop):
        """(data set, its rows start ... stop - 1), each data set once."""
        lasts = {held: last for held, _, last, _ in self._sets().values()}
        for held, last in lasts.items():
            x = tree[held]
            yield held, x, x[:, start:stop] if last else x[start:stop]


class Hdf5(Tree):
    """An HDF5 file (MATLAB's 7.3 is one)."""

    def _open(self):
        import h5py

        return h5py.File(self.path, "r")

    def _shapes(self):
        import h5py

        shapes = {}

        def visit(name, item):
            if isinstance(item, h5py.Dataset) and item.dtype.kind in "fiu":
                if not name.startswith("#refs#"):
                    shapes[name] = item.shape

        with self._open() as file:
            file.visititems(visit)
        return shapes

    def rows(self, start, stop, path):
        """Some rows as a file of the same kind."""
        import h5py

        with self._open() as file, h5py.File(path, "w") as out:
            for held, x, values in self._slices(file, start, stop):
                out.create_dataset(held, data=values).attrs.update(x.attrs)


class Zarr(Tree):
    """A Zarr store, format 2 or 3: a folder, or one that was zipped."""

    @contextmanager
    def _open(self):
        yield zarr_store.arrays_of(self.path)

    def _shapes(self):
        return {name: x.shape for name, x in zarr_store.arrays_of(self.path).items()}

    def rows(self, start, stop, path):
        """Some rows as a store in a folder."""
        with self._open() as tree:
            slices = self._slices(tree, start, stop)
            zarr_store.write(path, {held: values for held, _, values in slices})
