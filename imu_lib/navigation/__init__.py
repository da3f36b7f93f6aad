"""Navigation: from increments of angle and velocity to positions, and what an error model is worth
when GNSS is away.

Position is latitude rad, longitude rad, height m; velocity NED m/s; attitude roll, pitch, yaw rad
from body (forward-right-down)
to navigation frame; the error states of the filter are north-east-down metres, m/s and rad
(estimate minus truth).

`earth`, `attitude`, `strapdown` : the mechanization; `trajectory`, `simulation`, `turin` : true
motion and simulated drives;
`alignment`, `states`, `filter`, `smoother`, `consistency` : the loosely coupled filter, its sensor
states taken from an error model;
`outages`, `statistics`, `ensemble` : the comparison of error models under GNSS outages.
"""
