"""Size selectivity: mesh penetration, retention curves, and curves fitted to sea-trial data."""
