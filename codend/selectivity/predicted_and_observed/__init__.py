"""The prediction beside trials at sea, and calibrated on them."""
