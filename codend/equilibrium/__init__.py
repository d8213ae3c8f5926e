"""From a plan's net to its equilibrium: starts in the order tried, the model that is enough, how far off it may be."""
