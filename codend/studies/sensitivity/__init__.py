"""What every number of a plan does to drag, catch, opening, L50 and SR: derivatives, and intervals by tolerances."""
