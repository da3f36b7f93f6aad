"""`python -m imu_lib` is `imu-lib`."""

import sys

from imu_lib.cli.main import main

sys.exit(main())
