"""A record drawn from a model piece by piece: the samples that `Model.simulate_record` draws, for
records that do not fit into memory.

Each channel goes through scratch files on disk: its terms are added up there one after the other,
each in the order in which the generator serves it, then filtered and passed through the output
stages. What a stage or a process on the record cannot do by pieces is done on one channel at once.
"""

from imu_lib.drawing.record import Drawn, by_pieces, draw

__all__ = ["Drawn", "by_pieces", "draw"]
