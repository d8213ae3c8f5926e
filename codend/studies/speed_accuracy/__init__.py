"""Speed against accuracy: one catch solved by every method and model, beside an answer converged far beyond."""
