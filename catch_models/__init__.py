"""The catch: how far it fills the bag and the pressure it puts on netting. Knows no solver and no net."""
