"""Other structures of netting than a codend."""
