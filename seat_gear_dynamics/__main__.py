"""`python -m seat_gear_dynamics` is `seat-gear`."""

from seat_gear_dynamics.commands import main

raise SystemExit(main())
