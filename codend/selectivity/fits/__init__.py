"""Retention curves fitted to the fish counted in hauls."""
