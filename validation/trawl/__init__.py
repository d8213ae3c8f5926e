"""The papers' trawl: a pelagic trawl from a published plan, shot and towed."""
