"""The gap on a drive: what does the filter not know about this car?

    found = gap.drive.close(drive, model)   # or close(drive): the noise is fitted to the drive
    found.steps, found.unexplained          # named effects; what no effect accounts for
    found.model                             # the error model with its key `drive`

The innovations of the filter are whitened and put beside what each parameter does to them
(`condense`, `problem`); effects compete by penalised likelihood (`select`, `random_effects`), are
held, and the path is built anew (`search`). `battery` asks whether what is left is white; `outage`
what the answer is worth where the search has not looked.
"""

from .effects import CATALOGUE
from .loop import DriveReport, close

__all__ = ["CATALOGUE", "DriveReport", "close"]
