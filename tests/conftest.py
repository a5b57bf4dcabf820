"""Settings for all property tests."""

from __future__ import annotations

from hypothesis import HealthCheck, settings

# A property holds or fails however busy the machine is: no example has to be quick.
settings.register_profile(
    "patient", deadline=None, suppress_health_check=[HealthCheck.too_slow], print_blob=True
)
settings.load_profile("patient")
